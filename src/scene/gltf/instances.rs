//! Many copies of a mesh on one node (`EXT_mesh_gpu_instancing`).

use glam::{DAffine3, DQuat, DVec3, DVec4};

use super::accessors;
use super::animations::index_of;
use super::document::Document;
use super::extension::Body;
use super::hierarchy::PlacedNode;
use crate::scene::error::SceneError;
use crate::scene::world::Transform;

/// The extension.
pub const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// Most copies on one node.
const COPIES_MAX: u64 = 1 << 19;

/// Where a mesh stands that hangs on a node which stands in a place, and what tells the copies
/// apart in names: one, unless the node has several.
pub fn places(
    document: &Document,
    placed: &PlacedNode,
    node: &Body,
    place: Transform,
) -> Result<Vec<(String, Transform)>, SceneError> {
    let extensions = &document.value["nodes"][placed.node]["extensions"];
    let attributes = &extensions[INSTANCING]["attributes"];
    if extensions[INSTANCING].is_null() {
        return Ok(vec![(String::new(), place)]);
    }
    let label = format!("{}, {INSTANCING}", node.label());
    let accessor = |name: &str| {
        let at = format!("{label}, {name}");
        let len = document.root.accessors.len();
        let index = || index_of(&attributes[name], len, || at.clone());
        (!attributes[name].is_null()).then(|| Ok((index()?, at.clone()))).transpose()
    };
    let [moves, turns, scales] =
        [accessor("TRANSLATION")?, accessor("ROTATION")?, accessor("SCALE")?];
    let counts = [&moves, &turns, &scales]
        .map(|read| read.as_ref().map(|(accessor, _)| accessors::count(document, *accessor)));
    let Some(count) = counts.into_iter().flatten().next() else {
        let remedy = "add TRANSLATION, ROTATION or SCALE, or remove the extension";
        return Err(SceneError::new(label, "says nowhere where the copies stand", remedy));
    };
    if count > COPIES_MAX {
        let problem = format!("{count} copies are more than {COPIES_MAX}");
        return Err(SceneError::new(label, problem, "use fewer"));
    }
    if counts.into_iter().flatten().any(|other| other != count) {
        let problem = "its accessors are not of one length";
        return Err(SceneError::new(label, problem, "export the scene again"));
    }
    let vectors = |read: Option<(usize, String)>| {
        read.map(|(accessor, at)| accessors::vectors(document, accessor, &at)).transpose()
    };
    let (moves, scales) = (vectors(moves)?, vectors(scales)?);
    let turns =
        turns.map(|(accessor, at)| accessors::fours(document, accessor, &at)).transpose()?;
    let of = |all: &Option<Vec<[f32; 3]>>, index: usize, none: DVec3| {
        all.as_ref().map_or(none, |all| DVec3::from_array(all[index].map(f64::from)))
    };
    let copy = |index: usize| {
        let turn = turns.as_ref().map_or(DQuat::IDENTITY, |all| {
            let turn = DVec4::from_array(all[index].map(f64::from));
            DQuat::from_vec4(turn.try_normalize().unwrap_or(DVec4::W))
        });
        let (scale, translation) = (of(&scales, index, DVec3::ONE), of(&moves, index, DVec3::ZERO));
        let copy = DAffine3::from_scale_rotation_translation(scale, turn, translation);
        (format!(", copy {index}"), Transform(place.0 * copy))
    };
    Ok((0..count as usize).map(copy).collect())
}
