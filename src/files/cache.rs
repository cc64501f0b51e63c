//! Results that take long to compute, kept in files for the processes to come.
//!
//! Every result is a file of its own, named after the hash of all that it depends on:
//!
//! ```text
//! FOLDER/3/3f09...c2.table    magic, key, checksum, result
//! ```
//!
//! It appears by renaming, so that nobody reads half of one, however many write. What is damaged,
//! cut off, another's or no plain file is as good as absent, and nothing in here is an error: where
//! there is no folder, no permission or no space, results are computed every time.

use std::env;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

use super::temporary;

/// What the files begin with; the last digit is the format's.
const MAGIC: [u8; 8] = *b"SunTabl2";
/// What their names end with.
const SUFFIX: &str = ".table";
/// Length of what stands before the result: magic, key, checksum.
const HEADER: usize = 8 + 16 + 16;
/// Folders that the files are spread over, by the first digit of their names, so that whoever adds
/// one looks through few of them.
const FOLDERS: u64 = 16;
/// Most that the cache of the environment takes on the disk.
const BYTES_MAX: u64 = 128 << 20;
/// Files are marked as used again if the last mark is older.
const DAY: Duration = Duration::from_secs(24 * 3600);
/// Age at which temporary files are those of the dead, on whichever machine.
const HOUR: Duration = Duration::from_secs(3600);

/// What a result is known by: a hash of all that it depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(u128);

/// A key in the making; the order of what is added matters.
#[derive(Clone, Default)]
pub struct KeyBuilder(blake3::Hasher);

impl KeyBuilder {
    /// Adds text.
    pub fn text(&mut self, text: &str) {
        self.count(text.len());
        self.0.update(text.as_bytes());
    }

    /// Adds a count, or a number that stands for a kind.
    pub fn count(&mut self, count: usize) {
        self.0.update(&(count as u64).to_le_bytes());
    }

    /// Adds a number; such as are equal but in the sign of zero make other keys.
    pub fn number(&mut self, number: f64) {
        self.0.update(&number.to_bits().to_le_bytes());
    }

    /// Adds numbers, and how many they are.
    pub fn numbers(&mut self, numbers: &[f64]) {
        self.count(numbers.len());
        numbers.iter().for_each(|number| self.number(*number));
    }

    /// The key of all that was added.
    pub fn key(&self) -> Key {
        Key(u128::from_le_bytes(short(&self.0.finalize())))
    }
}

/// A folder of results.
#[derive(Debug)]
pub struct Cache {
    folder: PathBuf,
    /// Most that all files of one of the [`FOLDERS`] take together.
    folder_bytes_max: u64,
    /// Whether writing has failed once: this process does not try again.
    is_refused: AtomicBool,
}

impl Cache {
    /// The cache that the environment names, if any: the folder `SUNSTONE_CACHE`, or `sunstone`
    /// among the user's caches. It is looked up once.
    pub fn of_environment() -> Option<&'static Self> {
        static CACHE: LazyLock<Option<Cache>> = LazyLock::new(|| {
            let folder = folder_of(|name| env::var_os(name))?;
            Some(Cache::new(folder, BYTES_MAX))
        });
        CACHE.as_ref()
    }

    /// A cache in a folder, which is made when there is something to keep, of this size at most.
    pub fn new(folder: PathBuf, bytes_max: u64) -> Self {
        let folder_bytes_max = bytes_max / FOLDERS;
        Self { folder, folder_bytes_max, is_refused: AtomicBool::new(false) }
    }

    /// The result of a key, if it is there, whole, and of so many bytes.
    pub fn read(&self, key: Key, bytes: usize) -> Option<Vec<u8>> {
        let path = self.path(key);
        let length = (HEADER + bytes) as u64;
        // Neither a link is followed, nor a pipe or device opened.
        let found = fs::symlink_metadata(&path).ok()?;
        if !found.is_file() || found.len() != length {
            return None;
        }
        let file = File::open(&path).ok()?;
        let mut content = Vec::with_capacity(HEADER + bytes + 1);
        (&file).take(length + 1).read_to_end(&mut content).ok()?;
        let result = content.get(HEADER..)?;
        if result.len() != bytes || content[..HEADER] != header(key, result) {
            return None;
        }
        if found.modified().is_ok_and(|time| age(time, SystemTime::now()) > DAY) {
            // What is used stays; where it cannot be marked, it goes the sooner.
            let _ = file.set_modified(SystemTime::now());
        }
        content.drain(..HEADER);
        Some(content)
    }

    /// Keeps a result, if that is possible, and removes those that were not used for longest, if
    /// there are too many.
    pub fn write(&self, key: Key, result: &[u8]) {
        if self.is_refused.load(Ordering::Relaxed) {
            return;
        }
        if self.try_write(key, result).is_err() {
            self.is_refused.store(true, Ordering::Relaxed);
        }
    }

    fn try_write(&self, key: Key, result: &[u8]) -> io::Result<()> {
        if (HEADER + result.len()) as u64 > self.folder_bytes_max {
            return Ok(());
        }
        let path = self.path(key);
        let folder = path.parent().unwrap_or(&self.folder);
        fs::create_dir_all(folder)?;
        let (mut file, temporary) = temporary::create(folder)?;
        // It is not synced: a loss of power costs what the checksum tells.
        let written = file
            .write_all(&header(key, result))
            .and_then(|()| file.write_all(result))
            .and_then(|()| fs::rename(&temporary, &path));
        if written.is_err() {
            // Nothing sensible can be done if even that fails.
            let _ = fs::remove_file(&temporary);
        }
        written?;
        self.trim(folder, &path);
        Ok(())
    }

    /// Removes files of a folder until they are within the bound, the latest one last.
    fn trim(&self, folder: &Path, latest: &Path) {
        let mut files = files_in(folder);
        let mut total: u64 = files.iter().map(|file| file.bytes).sum();
        files.sort_by_key(|file| (file.path == latest, std::cmp::Reverse(file.age)));
        for file in files {
            if total <= self.folder_bytes_max {
                break;
            }
            match fs::remove_file(&file.path) {
                Ok(()) => total -= file.bytes,
                // Another process was faster.
                Err(error) if error.kind() == io::ErrorKind::NotFound => total -= file.bytes,
                Err(_) => {}
            }
        }
    }

    fn path(&self, key: Key) -> PathBuf {
        let name = format!("{:032x}", key.0);
        self.folder.join(&name[..1]).join(name + SUFFIX)
    }
}

/// The folder that variables of the environment name. Paths that are not absolute name none, as
/// those of `XDG_CACHE_HOME` must be: `off` is one.
fn folder_of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let path = |name| variable(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let absolute = |path: &PathBuf| path.is_absolute();
    if let Some(folder) = path("SUNSTONE_CACHE") {
        return Some(folder).filter(absolute);
    }
    let caches = path("XDG_CACHE_HOME").filter(absolute);
    let caches = caches.or_else(|| Some(path("HOME").filter(absolute)?.join(".cache")));
    Some(caches?.join("sunstone"))
}

/// As much of a digest as tells billions of results apart.
fn short(digest: &blake3::Hash) -> [u8; 16] {
    std::array::from_fn(|index| digest.as_bytes()[index])
}

fn header(key: Key, result: &[u8]) -> [u8; HEADER] {
    let mut header = [0; HEADER];
    header[..8].copy_from_slice(&MAGIC);
    header[8..24].copy_from_slice(&key.0.to_le_bytes());
    header[24..].copy_from_slice(&short(&blake3::hash(result)));
    header
}

/// A result on the disk.
struct Kept {
    path: PathBuf,
    bytes: u64,
    age: Duration,
}

/// The results in a folder; whatever else there is, nobody has asked for. Temporary files of the
/// dead are removed.
fn files_in(folder: &Path) -> Vec<Kept> {
    let now = SystemTime::now();
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(name) = name.to_str() else { continue };
        let is_temporary = temporary::is_name(name);
        if !(is_temporary || is_result(name)) {
            continue;
        }
        let Ok(found) = entry.metadata() else { continue };
        let Ok(modified) = found.modified() else { continue };
        let kept = Kept { path: entry.path(), bytes: found.len(), age: age(modified, now) };
        if !found.is_file() {
            continue;
        }
        match is_temporary {
            true if kept.age > HOUR => drop(fs::remove_file(&kept.path)),
            true => {}
            false => files.push(kept),
        }
    }
    files
}

fn is_result(name: &str) -> bool {
    let digits = name.strip_suffix(SUFFIX).unwrap_or("");
    digits.len() == 32 && digits.bytes().all(|digit| digit.is_ascii_hexdigit())
}

/// How long ago a time was. Clocks differ a little; what is far to come is of one that was wrong,
/// and as old as can be, or it would stay forever.
fn age(time: SystemTime, now: SystemTime) -> Duration {
    match now.duration_since(time) {
        Ok(age) => age,
        Err(ahead) if ahead.duration() < DAY => Duration::ZERO,
        Err(_) => Duration::MAX,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let name = format!("sunstone-cache-{name}-{}", std::process::id());
        let folder = env::temp_dir().join(name);
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    fn key(number: usize) -> Key {
        let mut key = KeyBuilder::default();
        key.count(number);
        key.key()
    }

    /// Keys whose results lie in one folder.
    fn neighbors() -> impl Iterator<Item = Key> {
        (0..).map(key).filter(|key| key.0 >> 124 == 7)
    }

    fn set_age(path: &Path, time: SystemTime) {
        File::options().append(true).open(path).unwrap().set_modified(time).unwrap();
    }

    #[test]
    fn the_environment_names_the_folder() {
        let folder = |variables: &[(&str, &str)]| {
            let found = folder_of(|name| {
                let value = variables.iter().find(|(of, _)| *of == name)?.1;
                Some(OsString::from(value))
            });
            found.map(|path| path.to_str().unwrap().to_owned())
        };
        let (own, caches, home) = ("SUNSTONE_CACHE", "XDG_CACHE_HOME", "HOME");
        let found = |variables: &[(&str, &str)], path: &str| {
            assert_eq!(folder(variables).as_deref(), Some(path), "{variables:?}");
        };
        found(&[(own, "/a b"), (caches, "/c"), (home, "/h")], "/a b");
        found(&[(own, ""), (caches, "/c"), (home, "/h")], "/c/sunstone");
        found(&[(caches, "relative"), (home, "/h")], "/h/.cache/sunstone");
        found(&[(caches, ""), (home, "/h")], "/h/.cache/sunstone");
        let off = [(own, "off"), (caches, "/c"), (home, "/h")];
        for variables in [&off[..], &[(own, "0"), (home, "/h")], &[(home, "h")], &[]] {
            assert_eq!(folder(variables), None, "{variables:?}");
        }
    }

    #[test]
    fn what_is_kept_is_found_again_by_its_key_and_length() {
        let folder = folder("kept");
        let cache = Cache::new(folder.join("a/b"), 1 << 20);
        assert_eq!(cache.read(key(1), 5), None);
        assert!(!folder.exists(), "nothing was to be kept");
        cache.write(key(1), b"hello");
        assert_eq!(cache.read(key(1), 5).as_deref(), Some(&b"hello"[..]));
        assert!(cache.read(key(1), 4).is_none() && cache.read(key(2), 5).is_none());
        cache.write(key(1), b"other");
        assert_eq!(cache.read(key(1), 5).as_deref(), Some(&b"other"[..]));
        let name = cache.path(key(1));
        assert_eq!(fs::read_dir(name.parent().unwrap()).unwrap().count(), 1);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn what_is_damaged_is_absent_and_written_anew() {
        let folder = folder("damaged");
        let cache = Cache::new(folder.clone(), 1 << 20);
        let path = cache.path(key(1));
        cache.write(key(2), b"world");
        cache.write(key(1), b"hello");
        let whole = fs::read(&path).unwrap();
        let foreign = fs::read(cache.path(key(2))).unwrap();
        let mut damaged: Vec<Vec<u8>> = (0..whole.len())
            .map(|place| {
                let mut bytes = whole.clone();
                bytes[place] ^= 4;
                bytes
            })
            .collect();
        damaged.extend((0..whole.len()).map(|length| whole[..length].to_vec()));
        damaged.extend([foreign, vec![0; whole.len()], [&whole[..], b"!"].concat()]);
        for bytes in damaged {
            fs::write(&path, &bytes).unwrap();
            assert_eq!(cache.read(key(1), 5), None, "{bytes:?}");
            cache.write(key(1), b"hello");
            assert!(fs::read(&path).unwrap() == whole);
        }
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    #[cfg(unix)]
    fn links_pipes_and_folders_are_no_results() {
        let folder = folder("links");
        let cache = Cache::new(folder.clone(), 1 << 20);
        let path = cache.path(key(1));
        cache.write(key(1), b"hello");
        let elsewhere = folder.join("elsewhere");
        fs::rename(&path, &elsewhere).unwrap();
        for target in [&elsewhere, Path::new("/dev/zero"), &folder.join("nowhere"), &path] {
            std::os::unix::fs::symlink(target, &path).unwrap();
            assert_eq!(cache.read(key(1), 5), None);
            cache.write(key(1), b"hello");
            assert!(
                cache.read(key(1), 5).is_some() && fs::symlink_metadata(&path).unwrap().is_file()
            );
            fs::remove_file(&path).unwrap();
        }
        // A linked folder is one.
        let linked = folder.join("linked");
        std::os::unix::fs::symlink(folder.join("elsewhere-2"), &linked).unwrap();
        fs::create_dir(folder.join("elsewhere-2")).unwrap();
        let by_link = Cache::new(linked, 1 << 20);
        by_link.write(key(1), b"hello");
        assert!(by_link.read(key(1), 5).is_some());
        fs::create_dir(&path).unwrap();
        assert_eq!(cache.read(key(1), 5), None);
        cache.write(key(1), b"hello");
        assert!(path.is_dir() && cache.is_refused.load(Ordering::Relaxed));
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn where_nothing_can_be_written_nothing_happens() {
        let folder = folder("refused");
        fs::create_dir(&folder).unwrap();
        let file = folder.join("file");
        fs::write(&file, "mine").unwrap();
        for place in [file.clone(), file.join("below"), folder.join("x".repeat(300))] {
            let cache = Cache::new(place, 1 << 20);
            cache.write(key(1), b"hello");
            assert!(cache.is_refused.load(Ordering::Relaxed));
            cache.write(key(1), b"hello");
            assert_eq!(cache.read(key(1), 5), None);
        }
        assert_eq!(fs::read(&file).unwrap(), b"mine");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn the_oldest_go_when_there_are_too_many() {
        let folder = folder("many");
        let length = (HEADER + 100) as u64;
        let cache = Cache::new(folder.clone(), FOLDERS * 4 * length);
        let keys: Vec<Key> = neighbors().take(8).collect();
        let there = |keys: &[Key]| -> Vec<bool> {
            keys.iter().map(|key| cache.path(*key).exists()).collect()
        };
        let now = SystemTime::now();
        let ago = |days: u32| now - days * DAY;
        for (number, key) in (0..).zip(&keys[..4]) {
            cache.write(*key, &[number; 100]);
            set_age(&cache.path(*key), ago(10 - u32::from(number)));
        }
        // Whoever is read stays.
        assert!(cache.read(keys[0], 100).is_some());
        let home = cache.path(keys[0]).parent().unwrap().to_owned();
        let [dead, alive] = ["a-1-0", "b-1-0"].map(|of| home.join(format!(".sunstone-{of}.tmp")));
        let foreign = home.join("thesis.tex");
        for path in [&dead, &alive, &foreign] {
            fs::write(path, [0; 1000]).unwrap();
        }
        [&dead, &foreign].into_iter().for_each(|path| set_age(path, ago(400)));
        cache.write(keys[4], &[4; 100]);
        assert_eq!(there(&keys[..5]), [true, false, true, true, true]);
        assert!(!dead.exists() && alive.exists() && foreign.exists());
        // A clock that was wrong.
        set_age(&cache.path(keys[4]), now + 1000 * DAY);
        cache.write(keys[5], &[5; 100]);
        assert_eq!(there(&keys[..6]), [true, false, true, true, false, true]);
        // One that is too large.
        cache.write(keys[6], &[6; 1000]);
        assert_eq!(there(&keys[..7]), [true, false, true, true, false, true, false]);
        assert!(foreign.exists());
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn many_write_and_read_at_once() {
        let folder = folder("at-once");
        let cache = Cache::new(folder.clone(), FOLDERS * 3 * (HEADER + 5000) as u64);
        let keys: Vec<Key> = neighbors().take(6).collect();
        let result = |index: usize| vec![index as u8; 5000];
        std::thread::scope(|scope| {
            for thread in 0..8 {
                let (folder, keys) = (folder.clone(), &keys);
                scope.spawn(move || {
                    let cache = Cache::new(folder, FOLDERS * 3 * (HEADER + 5000) as u64);
                    for round in 0..50 {
                        let index = (round + thread) % keys.len();
                        let found = cache.read(keys[index], 5000);
                        assert!(found.is_none_or(|found| found == result(index)));
                        cache.write(keys[index], &result(index));
                    }
                    assert!(!cache.is_refused.load(Ordering::Relaxed));
                });
            }
        });
        let home = cache.path(keys[0]).parent().unwrap().to_owned();
        assert!((1..=3).contains(&fs::read_dir(home).unwrap().count()));
        fs::remove_dir_all(folder).unwrap();
    }
}
