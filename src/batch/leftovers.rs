//! Files of parts beside images: what tasks have rendered, and what is of no use any more.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::{fs, io};

use super::known::Known;
use super::order::{Checksums, Order};
use super::share::{Share, pieces_of};
use crate::image::folder_of;
use crate::math::text::counted;

const PARTS: [&str; 2] = ["part", "parts"];
const IMAGES: [&str; 2] = ["image", "images"];

/// Files of parts by the images that they are of, in whatever division. They are of no use when
/// their image is there.
pub struct Leftovers(HashMap<PathBuf, Vec<Leftover>>);

/// The file of a part.
struct Leftover {
    path: PathBuf,
    /// What its name has beyond that of the image.
    suffix: String,
    /// How many parts the image has with it.
    of: u32,
}

impl Leftovers {
    /// Looks for them beside the outputs.
    pub fn find(orders: &[Order]) -> Self {
        let outputs: HashSet<&Path> = orders.iter().map(|order| &*order.output).collect();
        let folders: HashSet<PathBuf> = outputs.iter().map(|output| folder_of(output)).collect();
        let mut found: HashMap<PathBuf, Vec<Leftover>> = HashMap::new();
        for folder in folders {
            // There are no parts in a folder that is not there.
            let Ok(entries) = fs::read_dir(&folder) else { continue };
            for name in entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok()) {
                let Some((image, of)) = image_of_part(&name) else { continue };
                // No dot before what lies in the current folder, as outputs have none.
                let at = |name: &str| match folder == Path::new(".") {
                    true => PathBuf::from(name),
                    false => folder.join(name),
                };
                if outputs.contains(&*at(image)) {
                    let suffix = name[image.len()..].to_owned();
                    let leftover = Leftover { path: at(&name), suffix, of };
                    found.entry(at(image)).or_default().push(leftover);
                }
            }
        }
        Self(found)
    }

    /// Keeps those that tasks have noted; returns the others.
    pub fn keep_noted(&mut self, orders: &[Order], known: &Known) -> Vec<PathBuf> {
        let mut others = Vec::new();
        for order in orders {
            let Some(files) = self.0.get_mut(&order.output) else { continue };
            let is_noted =
                |it: &Leftover| known.tells_of(&format!("{}{}", order.output_name, it.suffix));
            let (noted, strange) = std::mem::take(files).into_iter().partition(is_noted);
            *files = noted;
            others.extend(strange.into_iter().map(|it: Leftover| it.path));
        }
        self.0.retain(|_, files| !files.is_empty());
        others.sort();
        others
    }

    /// The images among these that can be made of their parts, by index, with how many there are.
    pub fn whole(
        &self,
        orders: &[Order],
        known: &Known,
        (folder, checksums): (&Path, &Checksums),
    ) -> HashMap<usize, u32> {
        let division = |order: &Order| {
            let files = self.0.get(&order.output)?;
            let divisions: BTreeSet<u32> = files.iter().map(|it| it.of).collect();
            divisions.into_iter().filter(|of| *of > 1).find(|of| {
                // Not all are there: no need to read any.
                files.iter().filter(|it| it.of == *of).count() == *of as usize
                    && pieces_of(order, *of).is_ok_and(|pieces| {
                        pieces.iter().all(|it| known.done(it, folder, checksums).is_some())
                    })
            })
        };
        orders.iter().filter_map(|order| Some((order.index, division(order)?))).collect()
    }

    /// How many parts there are of images among these that cannot be made of them, in words.
    pub fn incomplete(&self, orders: &[Order], whole: &HashMap<usize, u32>) -> Option<String> {
        let left = orders.iter().filter(|order| !whole.contains_key(&order.index));
        let counts: Vec<usize> =
            left.filter_map(|order| self.0.get(&order.output)).map(Vec::len).collect();
        let images = match counts.len() {
            0 => return None,
            count => counted(count, IMAGES),
        };
        Some(format!("{} of {images}", counted(counts.iter().sum(), PARTS)))
    }

    /// One of an image of which there are more or fewer parts than so many.
    pub fn of_other_number(&self, output: &Path, parts: u32) -> Option<&PathBuf> {
        let files = self.0.get(output).into_iter().flatten();
        files.filter(|it| it.of != parts).map(|it| &it.path).min()
    }

    /// Removes those of an image.
    ///
    /// # Errors
    /// When one is left.
    pub fn remove(&self, output: &Path) -> io::Result<()> {
        for Leftover { path, .. } in self.0.get(output).into_iter().flatten() {
            match fs::remove_file(path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                Ok(()) | Err(_) => {}
            }
        }
        Ok(())
    }
}

/// The file name of the image that a part is of, and how many parts that has, by the part's.
fn image_of_part(name: &str) -> Option<(&str, u32)> {
    let (image, number) = name.strip_suffix(".part")?.rsplit_once('.')?;
    let share: Share = number.replacen("-of-", "/", 1).parse().ok()?;
    Some((image, share.of()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_known_by_their_names() {
        for (name, image) in [
            ("a.exr.2-of-7.part", Some(("a.exr", 7))),
            ("a b-0.5.exr.7-of-7.part", Some(("a b-0.5.exr", 7))),
            ("a.exr.8-of-7.part", None),
            ("a.exr.part", None),
            ("2-of-7.part", None),
            ("a.exr.2-of-7.part.checkpoint", None),
        ] {
            assert_eq!(image_of_part(name), image, "{name}");
        }
    }
}
