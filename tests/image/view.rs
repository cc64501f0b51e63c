//! The pages of `sunstone view`: the pixels in them are the images', and they refer to nothing
//! outside. What they show is looked at in a browser by `.ci/view/run`.

use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use sunstone::internals::image::StokesImage;
use sunstone::internals::image::view::{self, Named};
use sunstone::internals::spectrum::Color;

const MONO: Color = Color::Mono { wavelength_nm: 633.0 };

/// Values of all kinds, no two planes alike.
fn image(width: usize, height: usize, color: Color, components: usize) -> StokesImage {
    let mut image = StokesImage::new(width, height, color, components);
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1e-42, f32::MAX];
    for (i, plane) in image.planes.iter_mut().enumerate() {
        for (j, value) in plane.iter_mut().enumerate() {
            let chosen = odd.get(j % 13).filter(|_| i % 2 == 0);
            *value = chosen.copied().unwrap_or((i * 1000 + j) as f32 / 7.0);
        }
    }
    image
}

fn page(images: &[(&str, &StokesImage)]) -> String {
    let named: Vec<Named> = images.iter().map(|&(name, image)| Named { name, image }).collect();
    view::page(&named).unwrap()
}

/// What stands between the tags of the element of an id.
fn element<'a>(page: &'a str, id: &str) -> &'a str {
    let start = page.find(&format!("id=\"{id}\">")).unwrap_or_else(|| panic!("no {id}"));
    let rest = &page[start..];
    &rest[rest.find('>').unwrap() + 1..rest.find("</script>").unwrap()]
}

fn data(page: &str) -> Value {
    serde_json::from_str(element(page, "data")).unwrap()
}

fn bits(page: &str, id: &str) -> Vec<u32> {
    let packed = STANDARD.decode(element(page, id)).unwrap();
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).unwrap();
    let (words, rest) = bytes.as_chunks::<4>();
    assert!(rest.is_empty());
    words.iter().map(|word| u32::from_le_bytes(*word)).collect()
}

#[test]
fn pixels_are_the_images_bit_for_bit() {
    for (color, components) in [(Color::Rgb, 4), (Color::Rgb, 1), (MONO, 4), (MONO, 1)] {
        for (width, height) in [(1, 1), (17, 5), (300, 200)] {
            let mut image = image(width, height, color.clone(), components);
            image.variance = Some(image.planes.iter().rev().cloned().collect());
            let page = page(&[("a.exr", &image), ("b.exr", &image)]);
            for index in 0..2 {
                for (kind, planes) in
                    [("values", &image.planes), ("variances", image.variance.as_ref().unwrap())]
                {
                    for (i, plane) in planes.iter().enumerate() {
                        let expected: Vec<u32> =
                            plane.iter().map(|value| value.to_bits()).collect();
                        assert_eq!(bits(&page, &format!("pixels-{index}-{kind}-{i}")), expected);
                    }
                }
            }
            assert_eq!(data(&page)["images"][1]["components"], components);
        }
    }
}

#[test]
fn nothing_in_a_page_refers_to_the_network() {
    let page = page(&[("a.exr", &image(4, 4, Color::Rgb, 4))]);
    let [svg, policy] = ["http://www.w3.org/2000/svg", "content=\"default-src 'none';"];
    assert!(page.contains(policy), "a policy forbids what is not in the page");
    let rest = page.replace(svg, "");
    for word in ["http:", "https:", "//cdn", "src=", "@import", "url(", "fetch(", "XMLHttp"] {
        assert!(!rest.contains(word), "{word}");
    }
    assert_eq!(rest.matches("href=").count(), 1, "the empty icon alone");
}

#[test]
fn names_and_metadata_are_text() {
    let mut image = image(2, 2, MONO, 4);
    image.metadata.push(("scene".into(), "</script><script>alert(1)</script>\u{2028}".into()));
    let clean = page(&[("a.exr", &image)]);
    for name in ["<script>", "a\"b", "</script><!--", "{{pixels}}", "--><b>", "a\nb", "\u{202e}"] {
        let page = page(&[(name, &image)]);
        assert_eq!(page.matches("<script").count(), clean.matches("<script").count(), "{name}");
        assert_eq!(page.matches("</script>").count(), clean.matches("</script>").count());
        let data = data(&page);
        let shown = data["images"][0]["name"].as_str().unwrap();
        assert_eq!(shown == name, name != "\u{202e}", "{name}");
        assert_eq!(data["images"][0]["metadata"][0][1], image.metadata[0].1.as_str());
    }
    let titled = page(&[("<i>\"&", &image)]);
    assert!(titled.contains("<title>&lt;i&gt;&quot;&amp;</title>"));
}

#[test]
fn images_without_polarization_have_one_map() {
    let data = data(&page(&[("a.exr", &image(3, 2, Color::Rgb, 1))]));
    let ids: Vec<&str> =
        data["maps"].as_array().unwrap().iter().flat_map(|m| m["id"].as_str()).collect();
    assert_eq!(ids, ["intensity"]);
}

/// Scales of a divider's two sides are those of the one that needs more.
#[test]
fn two_images_share_their_scales() {
    let flat = |s1: f32| {
        let mut image = StokesImage::new(2, 2, MONO, 4);
        image.planes[0] = vec![1.0; 4];
        image.planes[1] = vec![s1; 4];
        image
    };
    let (weak, strong) = (flat(0.04), flat(0.15));
    for images in [[("a", &weak), ("b", &strong)], [("b", &strong), ("a", &weak)]] {
        let data = data(&page(&images));
        let end = data["end"].as_u64().unwrap() as usize;
        assert_eq!(data["ends"][end].as_f64().map(|end| end as f32), Some(0.2));
        let s1 = data["maps"].as_array().unwrap().iter().find(|map| map["id"] == "stokes-1");
        assert_eq!(s1.unwrap()["range"].as_f64().map(|range| range as f32), Some(0.15));
    }
}

#[test]
fn what_cannot_be_shown_is_refused_in_words() {
    let (small, large) = (image(2, 2, MONO, 4), image(3, 2, MONO, 4));
    let named = [Named { name: "a", image: &small }, Named { name: "b", image: &large }];
    let text = view::page(&named).unwrap_err().to_string();
    assert!(text.contains("a (2 x 2)") && text.contains("b (3 x 2)"), "{text}");
    let mut broken = small.clone();
    broken.planes.pop();
    let empty = StokesImage::new(0, 0, MONO, 4);
    for image in [&broken, &empty] {
        assert!(view::page(&[Named { name: "a", image }]).is_err());
    }
}
