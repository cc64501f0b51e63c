//! Writing a noisy image as OpenEXR, on one thread: ours, and as the `exr` crate would do it.

use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use sunstone::{Color, StokesImage};

const WIDTH: usize = 1920;
const HEIGHT: usize = 1080;

/// Smooth light with noise of a tenth, polarized by a few percent.
fn noisy() -> StokesImage {
    let mut bits = 1_u32;
    let mut unit = move || {
        bits ^= bits << 13;
        bits ^= bits >> 17;
        bits ^= bits << 5;
        bits as f32 / u32::MAX as f32
    };
    let mut image = StokesImage::new(WIDTH, HEIGHT, Color::Rgb, 4);
    for pixel in 0..WIDTH * HEIGHT {
        for channel in 0..3 {
            let s0 = (1.0 + (pixel % WIDTH) as f32 / WIDTH as f32) * (1.0 + 0.1 * unit());
            image.planes[channel][pixel] = s0;
            for component in 1..4 {
                image.planes[3 * component + channel][pixel] = 0.05 * s0 * (unit() - 0.5);
            }
        }
    }
    image
}

fn write_by_library(image: &StokesImage, path: &Path) {
    use exr::prelude::*;
    let names = ["R", "G", "B"].map(str::to_owned).into_iter().zip(0..3);
    let of_planes =
        |plane: usize| (format!("S{}.{}", plane / 3, ["R", "G", "B"][plane % 3]), plane);
    let channel = |(name, plane): (String, usize)| {
        AnyChannel::new(Text::new_or_panic(name), FlatSamples::F32(image.planes[plane].clone()))
    };
    let list = names.chain((0..12).map(of_planes)).map(channel).collect();
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: ::exr::image::Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (image.width, image.height);
    let layer = Layer::new(size, LayerAttributes::default(), encoding, AnyChannels::sort(list));
    Image::from_layer(layer).write().non_parallel().to_file(path).expect("room on the disk");
}

fn images(criterion: &mut Criterion) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let path = std::env::temp_dir().join(format!("sunstone-bench-{}.exr", std::process::id()));
    let image = noisy();
    let mut group = criterion.benchmark_group("write/exr/1080p");
    group.sample_size(10);
    group.throughput(Throughput::Elements((WIDTH * HEIGHT) as u64));
    group.bench_function("ours", |bench| {
        bench.iter(|| pool.install(|| image.save(&path)).expect("room on the disk"));
    });
    group.bench_function("library", |bench| bench.iter(|| write_by_library(&image, &path)));
    group.finish();
    let _ = std::fs::remove_file(path);
}

criterion_group!(benches, images);
criterion_main!(benches);
