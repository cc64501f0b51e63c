//! How light is found: the types of `<integrator>`, which are defaults of the command line.

use super::Import;
use super::fields::Fields;
use super::tree::{NAME, Tag};
use crate::math::text::excerpt;
use crate::scene::error::SceneError;
use crate::scene::world::Walk;

/// The types that find light.
const TYPES: [(&str, Walk); 5] = [
    ("direct", Walk::FromSensor),
    ("path", Walk::FromSensor),
    ("ptracer", Walk::FromEmitters),
    ("volpath", Walk::FromSensor),
    ("volpathmis", Walk::FromSensor),
];
/// Types that look at what another one finds: ours always tells the Stokes vector, and moments are
/// --variance's.
const AROUND: [&str; 2] = ["moment", "stokes"];
/// Longest paths of direct light.
const DIRECT: u32 = 2;

impl Import<'_> {
    /// Takes over what an integrator asks for.
    pub fn add_integrator(&mut self, object: usize) -> Result<(), SceneError> {
        let fields = Fields::of(self.tree, object);
        let plugin = fields.object.plugin.as_str();
        // How work is divided.
        fields.ignore(&["block_size", "samples_per_pass", "timeout"]);
        if fields.boolean("hide_emitters")? == Some(true) {
            return Err(fields.wrong("hide_emitters", "is not supported", "remove it"));
        }
        if AROUND.contains(&plugin) {
            for (_, inner) in fields.objects(Tag::Integrator) {
                self.add_integrator(inner)?;
            }
            return fields.finish();
        }
        let Some((_, walk)) = TYPES.iter().find(|(name, _)| *name == plugin) else {
            let problem = format!("`{}` is not supported", excerpt(plugin, NAME));
            let names: Vec<&str> = TYPES.iter().map(|(name, _)| *name).chain(AROUND).collect();
            return Err(fields.refuse(problem, format!("the types are {}", names.join(", "))));
        };
        self.world.asked.walk = Some(*walk);
        if plugin == "direct" {
            fields.ignore(&["shading_samples", "emitter_samples", "bsdf_samples"]);
            self.world.asked.path_length_max = Some(DIRECT);
            return fields.finish();
        }
        self.world.asked.path_length_max = match fields.integer("max_depth")? {
            None | Some(-1) => None,
            Some(depth) => {
                let most = u32::try_from(depth).ok().filter(|depth| *depth > 0);
                let problem = format!("{depth} must be -1, or at least 1");
                Some(most.ok_or_else(|| fields.wrong("max_depth", problem, ""))?)
            }
        };
        if let Some(depth) = fields.integer("rr_depth")? {
            let after = u32::try_from(depth).ok().filter(|depth| *depth > 0);
            let problem = format!("{depth} must be at least 1");
            self.world.asked.roulette_after =
                Some(after.ok_or_else(|| fields.wrong("rr_depth", problem, ""))?);
        }
        fields.finish()
    }
}
