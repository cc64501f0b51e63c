//! What has been edited and is in the file, but not in the scene that is seen: nobody reads it, and
//! what is wrong with it is told all the same, where it is edited.

use super::Import;
use super::cameras::read_camera;
use super::edit::Edit;
use super::extension::{Body, NODE};
use super::places::{Place, Step, places};
use crate::scene::error::{Findings, SceneError};
use crate::scene::world::Transform;

impl Import<'_> {
    /// Checks the objects that edits are about, as if they were used. The world is of no use then.
    pub fn check_edited(&mut self, edits: &[Edit]) -> Result<(), SceneError> {
        let mut findings = Findings::default();
        for edit in edits {
            let places = places(&self.document.value, &edit.target)?;
            for place in &places {
                findings.note(self.check_object(place));
            }
        }
        findings.result()
    }

    fn check_object(&mut self, place: &Place) -> Result<(), SceneError> {
        let list = place.iter().position(|step| matches!(step, Step::Index(_)));
        let Some(at) = list.filter(|at| *at > 0) else { return Ok(()) };
        let (Step::Key(list), Step::Index(index)) = (&place[at - 1], &place[at]) else {
            return Ok(());
        };
        let (document, index) = (self.document, *index);
        match list.as_str() {
            "materials" => {
                let label = document.label("materials", index);
                self.material(Some(index), &label).map(drop)
            }
            "cameras" => {
                let label = document.label("cameras", index);
                read_camera(document, index, &label).map(drop)
            }
            "lights" => self.add_light(index, "", Transform::IDENTITY),
            "nodes" => {
                let label = document.label("nodes", index);
                let body = Body::of(&document.value["nodes"][index], &label, &NODE)?;
                self.boundary(&body)?;
                match body.has("shape") || body.has("sphere_radius") {
                    true => self.ball(&body).map(drop),
                    false => Ok(()),
                }
            }
            // All media are read, used or not.
            _ => Ok(()),
        }
    }
}
