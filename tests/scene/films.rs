//! What files say of films: filters, crops and the shape of pixels.

use serde_json::json;
use sunstone::internals::film::filter::{Filter, FilterKind};
use sunstone::internals::render::{Options, PlacedWorld};
use sunstone::internals::scene::world::{Raster, Resolution, World};
use sunstone::internals::scene::{Written, load};

use crate::common::{load_bytes, scratch};

const GAUSSIAN: Filter = Filter { kind: FilterKind::Gaussian, radius: 2.0 };

/// The film that a glTF file has whose camera says this.
fn of_gltf(film: &serde_json::Value) -> Result<World, String> {
    let file = json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["SUNSTONE_polarization"],
        "cameras": [{
            "type": "perspective",
            "perspective": {"yfov": 1.0, "znear": 0.1, "aspectRatio": 2.0},
            "extensions": {"SUNSTONE_polarization": {"film": film}},
        }],
        "nodes": [{"camera": 0}],
        "scenes": [{"nodes": [0]}],
    });
    load_bytes("film.gltf", file.to_string().as_bytes()).map_err(|error| error.to_string())
}

fn of_xml(film: &str) -> Result<World, String> {
    let text = format!(
        "<scene version='3.0.0'><emitter type='constant'/><sensor type='perspective'>{film}\
         </sensor></scene>"
    );
    load_bytes("film.xml", text.as_bytes()).map_err(|error| error.to_string())
}

fn raster(world: &World) -> Raster {
    let mut query = world.entities().query::<&Raster>();
    let found = query.iter().next().copied();
    found.unwrap_or_default()
}

fn hdrfilm(body: &str) -> String {
    format!(
        "<film type='hdrfilm'><integer name='width' value='40'/><integer name='height' \
         value='30'/>{body}</film>"
    )
}

#[test]
fn gltf_says_how_pixels_see() {
    assert_eq!(raster(&of_gltf(&json!({})).unwrap()), Raster::default());
    let all = json!({"resolution": [40, 30], "filter": "mitchell", "filter_radius": 1.5,
        "crop": [1, 2, 30, 30], "pixel_aspect": 1.5});
    let world = of_gltf(&all).unwrap();
    let filter = Filter { kind: FilterKind::Mitchell, radius: 1.5 };
    let expected = Raster { filter, crop: Some([1, 2, 30, 30]), pixel_aspect: 1.5 };
    assert_eq!(raster(&world), expected);
    assert_eq!(world.warnings(), [] as [String; 0], "40 x 30 of 3 to 2 are 2 to 1");
    let text = world.describe();
    let words = "filter mitchell, radius 1.5, of which 1,2,30,30 are rendered, 1.5 times as wide";
    assert!(text.contains(words), "{text}");
    let tent = of_gltf(&json!({"filter": "tent"})).unwrap();
    assert_eq!(raster(&tent).filter, Filter::of(FilterKind::Tent));
    for (film, words) in [
        (
            json!({"filter": "bell"}),
            "film.filter is no filter\n  help: filters are box, tent, gaussian,",
        ),
        (json!({"filter_radius": 0.0099}), "filter_radius: 0.0099 must be from 0.01 to 32 pixels"),
        (json!({"filter_radius": 0}), "filter_radius: 0 must be from 0.01 to 32 pixels"),
        (json!({"filter": "box", "filter_radius": 40}), "40 must be from 0.01 to 32 pixels"),
        (json!({"pixel_aspect": -1}), "pixel_aspect: -1 must be from 0.01 to 100"),
        (json!({"crop": [0, 0, 1, 1]}), "crop is in pixels of a film that has no resolution"),
        (json!({"crop": [0, 0, 1], "resolution": [4, 4]}), "crop must be [x0, y0, x1, y1]"),
        (json!({"crop": [0, 0, 1.5, 1], "resolution": [4, 4]}), "crop must be [x0, y0, x1, y1]"),
        (json!({"crop": [0, 0, 5, 1], "resolution": [4, 4]}), "crop must be X0,Y0,X1,Y1 with"),
        (json!({"crop": [2, 0, 2, 1], "resolution": [4, 4]}), "crop must be X0,Y0,X1,Y1 with"),
    ] {
        let error = of_gltf(&film).map(|_| ()).expect_err(&film.to_string());
        assert!(error.contains(words), "{film}: {error}");
    }
}

#[test]
fn mitsuba_says_how_pixels_see() {
    let filter = |body: &str| raster(&of_xml(&hdrfilm(body)).unwrap()).filter;
    // Films that name no filter have a Gaussian one, those that are not there too.
    assert_eq!(filter(""), GAUSSIAN);
    assert_eq!(raster(&of_xml("").unwrap()).filter, GAUSSIAN);
    let number = |kind: &str, name: &str, value: f32| {
        format!("<rfilter type='{kind}'><float name='{name}' value='{value}'/></rfilter>")
    };
    for kind in FilterKind::ALL {
        let name = kind.name();
        assert_eq!(filter(&format!("<rfilter type='{name}'/>")), Filter::of(kind), "{name}");
    }
    let tent = Filter { kind: FilterKind::Tent, radius: 1.5 };
    assert_eq!(filter(&number("tent", "radius", 1.5)), tent);
    let narrow = Filter { radius: 1.0, ..GAUSSIAN };
    assert_eq!(filter(&number("gaussian", "stddev", 0.25)), narrow);
    let integer = |name: &str, value: u32| format!("<integer name='{name}' value='{value}'/>");
    let crop = integer("crop_offset_x", 5) + &integer("crop_offset_y", 6);
    let crop = crop + &integer("crop_width", 10) + &integer("crop_height", 24);
    let world = of_xml(&hdrfilm(&crop)).unwrap();
    assert_eq!(raster(&world).crop, Some([5, 6, 15, 30]));
    let whole = integer("crop_width", 40) + &integer("crop_height", 30);
    assert_eq!(raster(&of_xml(&hdrfilm(&whole)).unwrap()).crop, None);
    for (body, words) in [
        ("<rfilter type='bell'/>".to_owned(), "`bell` is not supported"),
        (number("tent", "radius", 0.0), "0 must be from 0.01 to 32 pixels"),
        (number("mitchell", "A", 0.5), "A: only 1/3 is supported"),
        (
            "<rfilter type='lanczos'><integer name='lobes' value='5'/></rfilter>".to_owned(),
            "lobes: only 3 are supported",
        ),
        (number("box", "radius", 1.0), "radius is no property of it"),
        (integer("crop_offset_x", 5), "the crop is not within the film"),
        (integer("crop_width", 0), "the crop is not within the film"),
    ] {
        let error = of_xml(&hdrfilm(&body)).map(|_| ()).expect_err(&body);
        assert!(error.contains(words), "{body}: {error}");
    }
}

/// What is written as glTF is read as it was.
#[test]
fn films_are_written_as_they_are() {
    let body = "<rfilter type='tent'><float name='radius' value='3'/></rfilter>\
                <integer name='crop_width' value='7'/>";
    let mut world = of_xml(&hdrfilm(body)).unwrap();
    world.set_raster(Raster { pixel_aspect: 0.5, ..raster(&world) }).unwrap();
    let written = Written::of(&world).unwrap_or_else(|error| panic!("{error}"));
    let path = scratch("again.gltf");
    written.save(&path).unwrap();
    let again = load(&path).unwrap();
    assert_eq!(raster(&again), raster(&world));
    let resolution = again.entities().query::<&Resolution>().iter().next().copied();
    assert_eq!(resolution, Some(Resolution([40, 30])));
}

/// A crop of the scene keeps its place on films of other sizes, and options go before it; an edge
/// that is not given follows from what the camera shows.
#[test]
fn options_go_before_the_scene() {
    let world = of_xml(&hdrfilm("<integer name='crop_width' value='20'/>")).unwrap();
    let placed = PlacedWorld::new(world).unwrap();
    let film = |options: Options| placed.film(&options).unwrap();
    let own = film(Options::default());
    assert_eq!((own.cut.size, own.filter, own.pixel_aspect), ([20, 30], GAUSSIAN, 1.0));
    let large = film(Options { width: Some(80), ..Options::default() });
    assert_eq!((large.cut.film, large.cut.size), ([80, 60], [40, 60]));
    let crop = "0%,50%,100%,100%".parse().ok();
    let lower = film(Options { crop, filter: Some(FilterKind::Box), ..Options::default() });
    assert_eq!((lower.cut.start, lower.cut.size), ([0, 15], [40, 15]));
    assert_eq!(lower.filter, Filter::PIXEL);
    let narrow = film(Options { filter_radius: Some(1.0), ..Options::default() });
    assert_eq!(narrow.filter, Filter { radius: 1.0, ..GAUSSIAN });
    let pixel_aspect = Some(2.0);
    let wide = film(Options { pixel_aspect, width: Some(40), ..Options::default() });
    assert_eq!(wide.cut.film, [40, 60], "a picture of 80 to 60");
    let tall = film(Options { pixel_aspect, height: Some(60), ..Options::default() });
    assert_eq!(tall.cut.film, [40, 60]);
    let beyond = Options { crop: "0,0,41,1".parse().ok(), ..Options::default() };
    assert!(placed.film(&beyond).unwrap_err().to_string().starts_with("crop must be X0,Y0,"));
}
