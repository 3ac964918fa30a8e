//! Writes rendered frames of a falling sphere and the truth: `render_frames FOLDER FRAMES WIDTH HEIGHT png|png16|jpeg|tiff [plain]`.

#[path = "../tests/render/mod.rs"]
mod render;

use std::path::PathBuf;

use rayon::prelude::*;
use render::Scene;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [folder, frames, width, height, format, rest @ ..] = words.as_slice() else {
        panic!("expected FOLDER FRAMES WIDTH HEIGHT FORMAT");
    };
    let folder = PathBuf::from(folder);
    let number = |word: &str| -> usize { word.parse().expect("a number") };
    let (frames, width, height) = (number(frames), number(width), number(height));
    let plain = rest.iter().any(|word| word == "plain");
    let plate = 0.85 * height as f64;
    let scene = Scene {
        width,
        height,
        gradient: if plain { 0.0 } else { 0.4 },
        shading: if plain { 0.0 } else { 0.3 },
        highlight: !plain,
        plate: (!plain).then_some(plate),
        mirror: if plain { 0.0 } else { 0.4 },
        ..Scene::default()
    };
    // down to 1.4 radii above the plate and up again
    let lowest = plate - 1.4 * scene.radius;
    let half = 0.5 * frames as f64;
    let fall = lowest - 1.5 * scene.radius;
    let centre = move |time: f64| {
        let from = (time - half) / half;
        (
            0.4 * width as f64 + 0.2 * width as f64 * from,
            lowest - fall * from.abs() * (0.7 + 0.3 * from.abs()),
        )
    };
    std::fs::create_dir_all(&folder).expect("a folder");
    if format == "tiff" {
        let pictures = (0..frames).map(|frame| render::render(&scene, centre, frame));
        render::tiff(&folder.join("frames.tif"), false, pictures);
    } else {
        (0..frames).into_par_iter().for_each(|frame| {
            let picture = render::render(&scene, centre, frame);
            match format.as_str() {
                "png16" => picture.png_of_16_bits(&folder.join(format!("{frame:06}.png"))),
                "jpeg" => picture.jpeg(&folder.join(format!("{frame:06}.jpg"))),
                _ => picture.png(&folder.join(format!("{frame:06}.png"))),
            }
        });
    }
    let truth = (0..frames).map(|frame| {
        let (x, y) = centre(frame as f64);
        format!("{frame},{x},{y}\n")
    });
    let text: String = std::iter::once("frame,x_px,y_px\n".to_owned()).chain(truth).collect();
    std::fs::write(folder.join("truth.csv"), text).expect("a place for the truth");
}
