//! Filters, crops and the shape of pixels on the command line and in files.

use exr::prelude::{AnyChannels, FlatSamples, Layer, ReadChannels, ReadLayers, read};
use sunstone::internals::image::StokesImage;

use crate::program::{folder, scene, sunstone};

const SMALL: [&str; 8] = ["--width", "20", "--height", "16", "--spp", "4", "--integrator", "path"];

/// A part of a film stands in its file where it is on the film, whole in its own display window,
/// with the shape of its pixels; its metadata say so, and are kept by what is made of it.
#[test]
fn files_say_where_on_the_film_they_are() {
    let here = folder("cropped-windows");
    let scene = scene("cornell");
    let render = |name: &str, more: &[&str]| {
        let words = [&["render", &scene, "-o", name][..], &SMALL, more].concat();
        sunstone(&here, &words).done();
        StokesImage::load(&here.join(name)).unwrap()
    };
    let more = ["--crop", "4,8,19,15", "--filter", "gaussian", "--pixel-aspect", "1.25"];
    let image = render("crop.exr", &more);
    assert_eq!((image.width, image.height), (15, 7));
    assert_eq!(image.metadata("crop"), Some("4,8,19,15 of 20 x 16"));
    assert_eq!(image.metadata("filter"), Some("gaussian, radius 2"));
    assert_eq!(image.metadata("filter samples"), Some("shared"));
    assert_eq!(image.metadata("pixel aspect"), Some("1.25"));
    let windows = |name: &str| {
        let file = read().no_deep_data().largest_resolution_level().all_channels();
        let file = file.first_valid_layer().all_attributes().from_file(here.join(name)).unwrap();
        let layer: Layer<AnyChannels<FlatSamples>> = file.layer_data;
        let window = file.attributes.display_window;
        let position = layer.attributes.layer_position;
        let [x, y, width, height] =
            [position.0, position.1, layer.size.0 as i32, layer.size.1 as i32];
        let whole =
            [window.position.0, window.position.1, window.size.0 as i32, window.size.1 as i32];
        ([x, y, width, height], whole, file.attributes.pixel_aspect)
    };
    assert_eq!(windows("crop.exr"), ([4, 8, 15, 7], [0, 0, 20, 16], 1.25));
    let plain = render("plain.exr", &[]);
    assert_eq!((plain.metadata("crop"), plain.metadata("pixel aspect")), (None, None));
    assert_eq!(plain.metadata("filter"), Some("box, radius 0.5"));
    assert_eq!(plain.metadata("filter samples"), None);
    let own = render("own.exr", &[&more[2..4], &["--filter-samples", "own"]].concat());
    assert_eq!(own.metadata("filter samples"), Some("own"));
    assert_eq!(windows("plain.exr"), ([0, 0, 20, 16], [0, 0, 20, 16], 1.0));
    // Written again, it stands where it stood; of another size, its place is not known.
    image.save(&here.join("again.exr")).unwrap();
    assert_eq!(windows("again.exr"), windows("crop.exr"));
    let mut other = StokesImage::new(3, 3, image.color.clone(), 1);
    other.metadata = image.metadata.clone();
    other.save(&here.join("other.exr")).unwrap();
    assert_eq!(windows("other.exr").1, [0, 0, 3, 3]);
}

/// Images by other filters are told apart, as are parts and what a render goes on from.
#[test]
fn other_filters_are_told() {
    let here = folder("cropped-others");
    let scene = scene("cornell");
    let render = |more: &[&str]| {
        let words = [&["render", &scene][..], &SMALL, more].concat();
        sunstone(&here, &words)
    };
    render(&["-o", "box.exr"]).done();
    render(&["-o", "tent.exr", "--filter", "tent"]).done();
    let run = sunstone(&here, &["compare", "box.exr", "tent.exr"]).done();
    let words = "warning: the filter of one is box, radius 0.5, of the other tent, radius 1";
    assert!(run.stderr.contains(words), "{}", run.stderr);
    let run = sunstone(&here, &["compare", "box.exr", "box.exr"]).done();
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);

    let crop = ["--crop", "25%,25%,75%,75%", "--filter", "mitchell"];
    for part in ["1/2", "2/2"] {
        let name = format!("{}.part", &part[..1]);
        render(&[&["-o", &name, "--part", part][..], &crop].concat()).done();
    }
    sunstone(&here, &["merge", "2.part", "1.part", "-o", "merged.exr"]).done();
    render(&[&["-o", "whole.exr"][..], &crop].concat()).done();
    let [merged, whole] =
        ["merged.exr", "whole.exr"].map(|name| StokesImage::load(&here.join(name)).unwrap());
    assert_eq!(merged.planes, whole.planes);
    assert_eq!(merged.metadata("crop"), Some("5,4,15,12 of 20 x 16"));
    let others = [&["-o", "3.part", "--part", "2/2"][..], &crop[..2], &["--filter", "lanczos"]];
    render(&others.concat()).done();
    let run = sunstone(&here, &["merge", "1.part", "3.part", "-o", "x.exr"]);
    let words = "the filter of one is mitchell, radius 2, of the other lanczos, radius 3";
    assert!(run.stderr.contains(words), "{}", run.stderr);
}

#[test]
fn what_no_film_is_like_is_refused() {
    let here = folder("cropped-refused");
    let scene = scene("cornell");
    for (more, words) in [
        (["--filter", "bell"], "invalid value 'bell' for '--filter <NAME>'"),
        (["--filter-radius", "0.009"], "--filter-radius 0.009 must be from 0.01 to 32 pixels"),
        (["--filter-radius", "0"], "--filter-radius 0 must be from 0.01 to 32 pixels"),
        (["--filter-radius", "nan"], "--filter-radius NaN must be from 0.01 to 32 pixels"),
        (["--pixel-aspect", "0"], "--pixel-aspect 0 must be from 0.01 to 100"),
        (["--filter-samples", "few"], "[possible values: shared, own]"),
        (["--crop", "1,2,3"], "must be X0,Y0,X1,Y1 in pixels, as 100,50,300,200"),
        (["--crop", "0,0,21,1"], "--crop must be X0,Y0,X1,Y1 with 0 <= X0 < X1 <= 20"),
        (["--crop", "5,5,5,9"], "not 5,5,5,9"),
    ] {
        let run =
            sunstone(&here, &[&["render", &scene, "-o", "x.exr"][..], &SMALL, &more].concat());
        assert!(run.stderr.contains(words), "{more:?}: {}", run.stderr);
        assert!(!here.join("x.exr").exists(), "{more:?}");
    }
}

/// Layers stand in the file beside the light, are told by `inspect`, and are drawn by their names.
#[test]
fn layers_are_kept_and_shown() {
    let here = folder("cropped-layers");
    let scene = scene("cornell");
    let render = |more: &[&str]| {
        let words = [&["render", &scene][..], &SMALL, more].concat();
        sunstone(&here, &words)
    };
    render(&["-o", "plain.exr"]).done();
    let layers = ["--layers", "depth,normal,object"];
    render(&[&["-o", "all.exr"][..], &layers].concat()).done();
    render(&[&["-o", "both.exr", "--variance"][..], &layers].concat()).done();
    let both = StokesImage::load(&here.join("both.exr")).unwrap();
    let [plain, all] =
        ["plain.exr", "all.exr"].map(|name| StokesImage::load(&here.join(name)).unwrap());
    assert!(plain.planes == all.planes, "layers change no light");
    assert!(plain.layers.is_empty() && both.variance.is_some());
    assert!(both.layers == all.layers && all.layers.len() == 3);
    let text = sunstone(&here, &["inspect", "all.exr"]).done().stdout;
    for name in ["depth.Z ", "normal.X ", "normal.Y ", "normal.Z ", "object.id "] {
        assert!(text.contains(name), "{name}: {text}");
    }
    all.save(&here.join("again.exr")).unwrap();
    assert!(StokesImage::load(&here.join("again.exr")).unwrap() == all, "it is read as written");
    let draw = ["visualize", "all.exr", "--map", "intensity", "-o", "depth.png", "--channel"];
    sunstone(&here, &[&draw[..], &["depth.Z"]].concat()).done();
    let run = sunstone(&here, &[&draw[..], &["albedo.R"]].concat());
    assert!(run.stderr.contains("depth.Z"), "{}", run.stderr);
    let run = render(&["-o", "x.png", "--layers", "depth"]);
    assert!(run.stderr.contains("--layers needs an output that ends in .exr"), "{}", run.stderr);
    let run = render(&["-o", "x.exr", "--layers", "z"]);
    assert!(run.stderr.contains("layers are depth, normal, albedo"), "{}", run.stderr);
}

/// Samples are not shared by a filter whose lobes hardly cancel, and nobody who asks for it gets
/// something else.
#[test]
fn samples_are_shared_where_they_can_be() {
    let here = folder("cropped-shared");
    let scene = scene("cornell");
    let render = |more: &[&str]| {
        let words = [&["render", &scene, "-o", "x.exr"][..], &SMALL, more].concat();
        sunstone(&here, &words)
    };
    let narrow = ["--filter", "lanczos", "--filter-radius", "1.2"];
    let run = render(&[&narrow[..], &["--filter-samples", "shared"]].concat());
    let words = "--filter-samples shared is not possible by this filter, lanczos, radius 1.2";
    assert!(run.stderr.contains(words), "{}", run.stderr);
    for (more, said) in [(&narrow[..], Some("own")), (&["--filter-samples", "shared"], None)] {
        render(more).done();
        let image = StokesImage::load(&here.join("x.exr")).unwrap();
        assert_eq!(image.metadata("filter samples"), said, "{more:?}");
    }
}
