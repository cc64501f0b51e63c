//! The cache of what takes long to compute: with it, without it and with what is left of it, images
//! have the same bits, and nobody hears of it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::{Value, json};
use sunstone::internals::image;

use crate::program::{folder, names_in, run, scene};

/// The tank with milk that holds no fat, whose table takes little time even without optimization.
fn skimmed(here: &Path) {
    let text = fs::read_to_string(scene("tank")).unwrap();
    let mut tank: Value = serde_json::from_str(&text).unwrap();
    let milk = &mut tank["extensions"]["SUNSTONE_polarization"]["media"][0]["milk"];
    assert!(milk["fat_percent"].is_number());
    milk["fat_percent"] = json!(0.0);
    fs::write(here.join("skimmed.gltf"), tank.to_string()).unwrap();
}

/// A render that knows only these variables of the environment.
fn command(here: &Path, scene: &str, output: &str, variables: &[(&str, &Path)]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sunstone"));
    command.current_dir(here).env_clear().envs(variables.iter().copied());
    command.args(["render", scene, "-o", output, "--width", "8", "--spp", "1", "--quiet"]);
    command.args(["--color", "mono", "--integrator", "path", "--threads", "2"]);
    command
}

/// The bits of an image.
fn bits(path: &Path) -> Vec<u32> {
    let image = image::load(path).unwrap();
    let planes = (0..image.components).flat_map(|component| image.plane(0, component));
    planes.map(|value| value.to_bits()).collect()
}

/// What is heard of a render, but that `path` does not find all of it.
fn heard(stderr: &str) -> Vec<&str> {
    stderr.lines().filter(|line| !line.starts_with("warning: points or directions")).collect()
}

/// The bits of such a render, of which nothing is to be heard.
fn rendered(here: &Path, variables: &[(&str, &Path)]) -> Vec<u32> {
    let run = run(&mut command(here, "skimmed.gltf", "image.exr", variables)).done();
    assert_eq!(run.stdout, "", "{}", run.command);
    assert_eq!(heard(&run.stderr), [""; 0], "{}", run.command);
    bits(&here.join("image.exr"))
}

/// All files of a cache.
fn tables(cache: &Path) -> Vec<PathBuf> {
    let folders = names_in(cache).into_iter().map(|name| cache.join(name));
    folders
        .flat_map(|folder| names_in(&folder).into_iter().map(move |it| folder.join(it)))
        .collect()
}

#[test]
fn the_bits_are_the_same_with_and_without_a_cache() {
    let here = folder("cache bits");
    skimmed(&here);
    let home = here.join("home");
    let expected = rendered(&here, &[("SUNSTONE_CACHE", Path::new("off")), ("HOME", &home)]);
    assert!(!home.exists());
    assert!(expected.iter().any(|bits| *bits != 0));
    let cache = here.join("tables, mine");
    let with = [("SUNSTONE_CACHE", &*cache)];
    assert!(rendered(&here, &with) == expected, "computed");
    let [table] = &tables(&cache)[..] else { panic!("{:?}", tables(&cache)) };
    let whole = fs::read(table).unwrap();
    let written = fs::metadata(table).unwrap().modified().unwrap();
    assert!(rendered(&here, &with) == expected, "of the cache");
    assert_eq!(fs::metadata(table).unwrap().modified().unwrap(), written);
    for damaged in
        [&whole[..whole.len() / 2], &[whole[..100].to_vec(), vec![0; whole.len() - 100]].concat()]
    {
        fs::write(table, damaged).unwrap();
        assert!(rendered(&here, &with) == expected, "of what is left of it");
        assert!(fs::read(table).unwrap() == whole, "mended");
    }
    assert_eq!(tables(&cache).len(), 1);
}

#[test]
fn it_is_where_the_environment_says_if_anywhere() {
    let here = folder("cache places");
    skimmed(&here);
    let [home, caches, file] = ["home", "caches", "file"].map(|name| here.join(name));
    fs::write(&file, "mine").unwrap();
    let expected = rendered(&here, &[]);
    for variables in [&[("HOME", &*home)][..], &[("XDG_CACHE_HOME", &*caches), ("HOME", &*home)]] {
        assert!(rendered(&here, variables) == expected);
    }
    assert_eq!(tables(&home.join(".cache/sunstone")).len(), 1);
    assert_eq!(tables(&caches.join("sunstone")).len(), 1);
    // Where there can be none, renders go on without.
    for place in [&*file, &file.join("below"), Path::new("/dev/null"), Path::new("0")] {
        assert!(rendered(&here, &[("SUNSTONE_CACHE", place), ("HOME", &home)]) == expected);
    }
    assert_eq!(fs::read(&file).unwrap(), b"mine");
    let names = ["caches", "file", "home", "image.exr", "skimmed.gltf"];
    assert_eq!(names_in(&here), names);
}

#[test]
fn scenes_without_tables_make_no_folder() {
    let here = folder("cache none");
    let cache = here.join("cache");
    let variables = [("SUNSTONE_CACHE", &*cache)];
    run(&mut command(&here, &scene("cornell"), "image.exr", &variables)).done();
    assert!(!cache.exists());
}

#[test]
fn processes_share_it() {
    let here = folder("cache shared");
    skimmed(&here);
    let expected = rendered(&here, &[]);
    let cache = here.join("cache");
    let names: Vec<String> = (0..6).map(|number| format!("{number}.exr")).collect();
    let start = |name: &String| {
        let mut command = command(&here, "skimmed.gltf", name, &[("SUNSTONE_CACHE", &cache)]);
        command.stderr(Stdio::piped()).spawn().unwrap()
    };
    let running: Vec<_> = names.iter().map(start).collect();
    for process in running {
        let output = process.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && heard(&stderr).is_empty(), "{output:?}");
    }
    assert!(names.iter().all(|name| bits(&here.join(name)) == expected));
    assert_eq!(tables(&cache).len(), 1);
}
