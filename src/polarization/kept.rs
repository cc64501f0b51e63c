//! What suspensions do to light, computed once: kept in the memory of the process and, where it
//! took long, in the cache of the environment for other processes.
//!
//! What is kept has the bits that computing it has, here and now. Hence the key of an entry is made
//! of all that goes into it: the suspension, the sources of this computation, the target, and what
//! the system's own functions are here.

use std::hint::black_box;
use std::sync::{Arc, LazyLock, Mutex};

use super::mie::PhaseElements;
use super::particles::{Particles, Scattering, Suspension};
use crate::files::cache::{Cache, Key, KeyBuilder};
use crate::math::elementary::{cbrt, cos, exp, ln, sin};

/// Most that the tables in memory take: those of a hundred milks in RGB.
const BYTES_MAX: usize = 16 << 20;
/// Least work that is worth a file, which is read in a tenth of a millisecond: single sizes are
/// computed in less but for the largest, distributions take some milliseconds at least.
const WORK_MIN: f64 = 1e6;
/// Numbers before the matrix, and in each of its rows.
const FIRST: usize = 3;
const ROW: usize = 4;

/// The same as [`Suspension::scattering`], bit for bit, from memory or the cache if it is there.
pub fn scattering(suspension: &Suspension, intervals: usize) -> Arc<Scattering> {
    static MEMORY: Memory = Memory::new(BYTES_MAX);
    kept_in(&MEMORY, Cache::of_environment, suspension, intervals)
}

/// The same with a memory and a cache, which is asked for only if it is needed.
///
/// No lock is held while it is computed, as the threads that compute take up other work of their
/// pool, too, which may come here: a table may be computed twice at a time.
fn kept_in<'a>(
    memory: &Memory,
    cache: impl FnOnce() -> Option<&'a Cache>,
    suspension: &Suspension,
    intervals: usize,
) -> Arc<Scattering> {
    let key = key(suspension, intervals);
    if let Some(found) = memory.get(key) {
        return found;
    }
    let is_long = suspension.work(intervals) >= WORK_MIN;
    let cache = if is_long { cache() } else { None };
    let bytes = size_of::<f64>() * (FIRST + ROW * (intervals + 1));
    let kept = cache.and_then(|cache| cache.read(key, bytes));
    let found = Arc::new(match &kept {
        Some(bytes) => from_bytes(bytes),
        None => suspension.scattering(intervals),
    });
    memory.add(key, &found);
    if let (Some(cache), None) = (cache, kept) {
        cache.write(key, &to_bytes(&found));
    }
    found
}

/// Of all that the numbers depend on.
fn key(suspension: &Suspension, intervals: usize) -> Key {
    let Suspension { particles, host_n, wavelength_nm } = suspension;
    let mut key = BUILD.clone();
    key.count(intervals);
    key.numbers(&[*host_n, *wavelength_nm]);
    key.count(particles.len());
    for Particles { sizes, n, k, volume_fraction } in particles {
        key.numbers(&sizes.numbers());
        key.numbers(&[*n, *k, *volume_fraction]);
    }
    key.key()
}

/// What keys begin with: the build, and where it runs. The functions of a system's library differ
/// in their last bits by its version and by the processor that it finds.
static BUILD: LazyLock<KeyBuilder> = LazyLock::new(|| {
    let mut key = KeyBuilder::default();
    key.text(env!("CARGO_PKG_VERSION"));
    for source in [include_str!("kept.rs"), include_str!("mie.rs"), include_str!("particles.rs")] {
        key.text(source);
    }
    key.text(std::env::consts::ARCH);
    key.text(std::env::consts::OS);
    key.count(usize::from(cfg!(debug_assertions)));
    for place in (1..=256).map(|step| black_box(0.37 * f64::from(step))) {
        key.numbers(&[sin(place), cos(place), cbrt(place), ln(place), exp(-place)]);
    }
    key
});

/// Tables of this process: the last was used latest.
struct Memory {
    tables: Mutex<Vec<(Key, Arc<Scattering>)>>,
    bytes_max: usize,
}

impl Memory {
    const fn new(bytes_max: usize) -> Self {
        Self { tables: Mutex::new(Vec::new()), bytes_max }
    }

    fn get(&self, key: Key) -> Option<Arc<Scattering>> {
        let mut tables = self.tables.lock().expect("no thread panics while it holds the lock");
        let place = tables.iter().position(|(of, _)| *of == key)?;
        tables[place..].rotate_left(1);
        tables.last().map(|(_, found)| Arc::clone(found))
    }

    fn add(&self, key: Key, found: &Arc<Scattering>) {
        let mut tables = self.tables.lock().expect("no thread panics while it holds the lock");
        tables.retain(|(of, _)| *of != key);
        tables.push((key, Arc::clone(found)));
        let mut total: usize = tables.iter().map(|(_, found)| bytes_of(found)).sum();
        while total > self.bytes_max {
            total -= bytes_of(&tables.remove(0).1);
        }
    }
}

fn bytes_of(found: &Scattering) -> usize {
    size_of::<Scattering>() + size_of_val(&*found.matrix)
}

fn to_bytes(found: &Scattering) -> Vec<u8> {
    let Scattering { sigma_s, sigma_a, g, matrix } = found;
    let first = [*sigma_s, *sigma_a, *g];
    let row = |m: &PhaseElements| [m.m00, m.m01, m.m22, m.m23];
    first.into_iter().chain(matrix.iter().flat_map(row)).flat_map(f64::to_le_bytes).collect()
}

/// Of as many bytes as [`to_bytes`] makes.
fn from_bytes(bytes: &[u8]) -> Scattering {
    let (numbers, _) = bytes.as_chunks();
    let numbers: Vec<f64> = numbers.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let (first, matrix) = numbers.split_at(FIRST);
    let (rows, _) = matrix.as_chunks::<ROW>();
    let elements = |&[m00, m01, m22, m23]: &[f64; ROW]| PhaseElements { m00, m01, m22, m23 };
    Scattering {
        sigma_s: first[0],
        sigma_a: first[1],
        g: first[2],
        matrix: rows.iter().map(elements).collect(),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::{Path, PathBuf};

    use super::*;
    use crate::polarization::particles::{Amount, Sizes};

    /// Half a second of work in all, without optimization.
    const INTERVALS: usize = 514;

    fn folder(name: &str) -> PathBuf {
        let name = format!("sunstone-kept-{name}-{}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    fn of(sizes: &Sizes) -> Suspension<'_> {
        let particles = vec![Particles { sizes, n: 1.5, k: 1e-3, volume_fraction: 1e-3 }];
        Suspension { particles, host_n: 1.33, wavelength_nm: 550.0 }
    }

    fn beads() -> Sizes {
        Sizes::log_normal(0.1, 0.03, Amount::Volume, None).unwrap()
    }

    fn files(folder: &Path) -> Vec<PathBuf> {
        let inside = |folder: &Path| fs::read_dir(folder).into_iter().flatten();
        let paths = inside(folder).flat_map(|entry| inside(&entry.unwrap().path()));
        paths.map(|entry| entry.unwrap().path()).collect()
    }

    #[test]
    fn all_ways_lead_to_the_same_bits() {
        let sizes = beads();
        let suspension = of(&sizes);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            to_bytes(&pool.install(|| suspension.scattering(INTERVALS)))
        };
        let expected = on(1);
        assert_eq!(expected.len(), size_of::<f64>() * (FIRST + ROW * (INTERVALS + 1)));
        assert!(on(3) == expected, "by three threads");
        let folder = folder("bits");
        let cache = Cache::new(folder.clone(), 1 << 20);
        for way in ["computed", "of the disk", "of the disk again"] {
            let memory = Memory::new(1 << 20);
            let found = kept_in(&memory, || Some(&cache), &suspension, INTERVALS);
            assert!(to_bytes(&found) == expected, "{way}");
            let again = kept_in(&memory, || panic!("it is in memory"), &suspension, INTERVALS);
            assert!(Arc::ptr_eq(&found, &again));
            assert_eq!(files(&folder).len(), 1);
        }
        // Another number in the right place is what is read.
        let key = key(&suspension, INTERVALS);
        let mut other = expected.clone();
        other[3] ^= 1;
        cache.write(key, &other);
        let found = kept_in(&Memory::new(0), || Some(&cache), &suspension, INTERVALS);
        assert!(to_bytes(&found) == other);
        // And none is where the file is damaged, which is then mended.
        let file = &files(&folder)[0];
        let mut bytes = fs::read(file).unwrap();
        bytes[1000] ^= 16;
        fs::write(file, bytes).unwrap();
        let found = kept_in(&Memory::new(0), || Some(&cache), &suspension, INTERVALS);
        assert!(to_bytes(&found) == expected);
        assert!(cache.read(key, expected.len()).unwrap() == expected);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_is_quick_leaves_no_folder() {
        let folder = folder("quick");
        let cache = Cache::new(folder.clone(), 1 << 20);
        let sizes = Sizes::monodisperse(0.5).unwrap();
        kept_in(&Memory::new(1 << 20), || Some(&cache), &of(&sizes), INTERVALS);
        assert!(!folder.exists());
    }

    #[test]
    fn every_number_makes_another_key() {
        let radii = [0.1, 0.2, 0.4];
        let sizes = [
            beads(),
            Sizes::log_normal(0.1, 0.03, Amount::Number, None).unwrap(),
            Sizes::log_normal(0.1, 0.03, Amount::Volume, Some([0.05, 0.2])).unwrap(),
            Sizes::log_normal(0.1, 0.031, Amount::Volume, None).unwrap(),
            Sizes::gamma(0.1, 0.03, Amount::Volume, None).unwrap(),
            Sizes::gamma(0.1, 0.031, Amount::Volume, None).unwrap(),
            Sizes::monodisperse(0.1).unwrap(),
            Sizes::monodisperse(0.2).unwrap(),
            Sizes::table(&radii, &[1.0, 2.0, 1.0], Amount::Volume).unwrap(),
            Sizes::table(&radii, &[1.0, 2.0, 3.0], Amount::Volume).unwrap(),
            Sizes::table(&radii[..2], &[1.0, 2.0], Amount::Volume).unwrap(),
        ];
        let mut keys: Vec<Key> = sizes.iter().map(|sizes| key(&of(sizes), INTERVALS)).collect();
        let first = of(&sizes[0]);
        keys.push(key(&first, INTERVALS + 2));
        keys.push(key(&Suspension { host_n: 1.34, ..first.clone() }, INTERVALS));
        keys.push(key(&Suspension { wavelength_nm: 551.0, ..first.clone() }, INTERVALS));
        let one = first.particles[0];
        for particles in [
            vec![Particles { n: 1.51, ..one }],
            vec![Particles { k: 0.0, ..one }],
            vec![Particles { k: -0.0, ..one }],
            vec![Particles { volume_fraction: 2e-3, ..one }],
            vec![one, one],
            vec![],
        ] {
            keys.push(key(&Suspension { particles, ..first.clone() }, INTERVALS));
        }
        for (index, of) in keys.iter().enumerate() {
            assert!(!keys[..index].contains(of), "{index}");
        }
        assert_eq!(keys[0], key(&of(&beads()), INTERVALS));
    }

    #[test]
    fn memory_forgets_what_was_not_used_for_longest() {
        let matrix = vec![PhaseElements { m00: 1.0, m01: 0.0, m22: 0.0, m23: 0.0 }; 100];
        let table = Arc::new(Scattering { sigma_s: 1.0, sigma_a: 0.0, g: 0.0, matrix });
        let memory = Memory::new(3 * bytes_of(&table));
        let keys: Vec<Key> = (0..5)
            .map(|number| {
                let mut key = KeyBuilder::default();
                key.count(number);
                key.key()
            })
            .collect();
        keys[..3].iter().for_each(|key| memory.add(*key, &table));
        assert!(memory.get(keys[0]).is_some());
        keys[3..].iter().for_each(|key| memory.add(*key, &table));
        let left: Vec<bool> = keys.iter().map(|key| memory.get(*key).is_some()).collect();
        assert_eq!(left, [true, false, false, true, true]);
        memory.add(keys[4], &table);
        assert!(memory.get(keys[0]).is_some(), "the same again takes no room");
        let none = Memory::new(0);
        none.add(keys[0], &table);
        assert!(none.get(keys[0]).is_none());
    }
}
