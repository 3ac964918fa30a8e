//! Renders frames of a falling sphere whose place is known: shaded, with a highlight, before a plate that mirrors it.
#![allow(dead_code)]

use std::borrow::Borrow;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageFormat};
use rand::rngs::ChaCha8Rng;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use tiff::encoder::{colortype, TiffEncoder};

/// What stands before the camera. Lengths in px, brightness in grey levels of 8 bits.
#[derive(Debug, Clone)]
pub struct Scene {
    pub width: usize,
    pub height: usize,
    pub radius: f64,
    pub background: f64,
    /// level of the sphere, where light falls on it, less that of the background
    pub contrast: f64,
    /// sd of a pixel
    pub noise: f64,
    /// change of the background's brightness over the width of the frame, and half of it over the height, relative
    pub gradient: f64,
    /// part of the sphere's brightness that comes from a lamp at the upper left; the rest comes from everywhere
    pub shading: f64,
    pub highlight: bool,
    /// height of the plate's near edge in the frame: below, the background is darker
    pub plate: Option<f64>,
    /// part of the sphere's contrast that its mirror image in the plate has, 0 for none
    pub mirror: f64,
    /// reach of a meniscus round the sphere where its lowest point is within as much of the plate, 0 for none
    pub meniscus: f64,
    /// part of the sphere's brightness that its shadow on a wall takes, 0 for none
    pub shadow: f64,
    /// exposure in frames, about the frame's time
    pub exposure: f64,
    /// relative amplitude of a flicker of ten frames, and relative drift in a thousand frames
    pub flicker: f64,
    pub drift: f64,
    /// a smaller disc that moves: its radius, 0 for none
    pub droplet: f64,
    /// a bar that stands still at the left
    pub bar: bool,
    pub seed: u64,
}

/// sd of the optics' blur, px.
const BLUR: f64 = 0.5;

impl Default for Scene {
    /// A bright sphere of 20 px before a dark background, of a contrast 20 times the noise, and nothing else.
    fn default() -> Scene {
        Scene {
            width: 200,
            height: 240,
            radius: 20.0,
            background: 40.0,
            contrast: 100.0,
            noise: 5.0,
            gradient: 0.0,
            shading: 0.0,
            highlight: false,
            plate: None,
            mirror: 0.0,
            meniscus: 0.0,
            shadow: 0.0,
            exposure: 0.0,
            flicker: 0.0,
            drift: 0.0,
            droplet: 0.0,
            bar: false,
            seed: 1,
        }
    }
}

/// A rendered frame, in grey levels of 8 bits that are not rounded.
pub struct Picture {
    pub width: usize,
    pub height: usize,
    pub levels: Vec<f64>,
}

/// The frame of such a number of a sphere whose centre follows a path over time in frames; the exposure is about the
/// frame's time, so that the truth is `centre(frame as f64)` where its speed does not change.
pub fn render(scene: &Scene, centre: impl Fn(f64) -> (f64, f64), frame: usize) -> Picture {
    let time = frame as f64;
    let (first, last) = (centre(time - 0.5 * scene.exposure), centre(time + 0.5 * scene.exposure));
    let length = (last.0 - first.0).hypot(last.1 - first.1);
    let moments = if length < 0.05 { 1 } else { (length * 1.5) as usize + 4 };
    let centres: Vec<(f64, f64)> = (0..moments)
        .map(|k| centre(time + scene.exposure * ((k as f64 + 0.5) / moments as f64 - 0.5)))
        .collect();
    let kernel = kernel(if moments > 8 { 0.5 } else { 0.25 });
    let brightness = (1.0 + scene.flicker * (0.6283 * time).sin()) * (1.0 + scene.drift * time / 1000.0);
    let mut rng = ChaCha8Rng::seed_from_u64(scene.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ frame as u64);
    let mut levels = Vec::with_capacity(scene.width * scene.height);
    for y in 0..scene.height {
        for x in 0..scene.width {
            let (x, y) = (x as f64, y as f64);
            let margin = 0.5 * length + 3.0 * BLUR + 1.5;
            let exact = scene.has_edge_near(x, y, centres[moments / 2], margin, time);
            let mut sum = 0.0;
            for centre in &centres {
                sum += if exact {
                    kernel
                        .iter()
                        .map(|(dx, dy, weight)| weight * scene.light(x + dx, y + dy, *centre, time))
                        .sum()
                } else {
                    scene.light(x, y, *centre, time)
                };
            }
            let noise: f64 = StandardNormal.sample(&mut rng);
            levels.push(brightness * sum / moments as f64 + scene.noise * noise);
        }
    }
    Picture {
        width: scene.width,
        height: scene.height,
        levels,
    }
}

/// What a pixel gathers: the square of its own, blurred by the optics, in steps of a pixel's part.
fn kernel(step: f64) -> Vec<(f64, f64, f64)> {
    let reach = ((0.5 + 2.0 * BLUR) / step).ceil() as i32;
    // of light that reaches a place of the sensor within the pixel
    let weight = |at: f64| -> f64 {
        let parts = (-200..=200).map(|k| f64::from(k) * 0.01 * BLUR);
        parts
            .map(|from| (-0.5 * (from / BLUR).powi(2)).exp() * f64::from((at - from).abs() <= 0.5))
            .sum()
    };
    let places = (-reach..=reach).map(|k| f64::from(k) * step);
    let offsets: Vec<(f64, f64)> = places.map(|at| (at, weight(at))).collect();
    let total: f64 = offsets.iter().map(|(_, weight)| weight).sum();
    let all = offsets
        .iter()
        .flat_map(|(dy, v)| offsets.iter().map(move |(dx, u)| (*dx, *dy, u * v / (total * total))));
    all.filter(|(_, _, weight)| *weight > 1e-6).collect()
}

impl Scene {
    /// Whether brightness changes too fast about a pixel for one sample.
    fn has_edge_near(&self, x: f64, y: f64, (cx, cy): (f64, f64), margin: f64, time: f64) -> bool {
        let near = |cx: f64, cy: f64, radius: f64| ((x - cx).hypot(y - cy) - radius).abs() < margin;
        let plate = self.plate.is_some_and(|plate| {
            let mirrored = self.mirror > 0.0 && near(cx, 2.0 * plate - cy, self.radius);
            let touches = self.meniscus > plate - self.radius - cy;
            let neck = touches && (x - cx).abs() < 1.5 * self.radius && (y - plate).abs() < 0.5 * self.radius;
            mirrored || neck || (y - plate).abs() < margin
        });
        let (dx, dy) = self.droplet_at(time);
        plate || near(cx, cy, self.radius) || (self.droplet > 0.0 && near(dx, dy, self.droplet))
    }

    fn droplet_at(&self, time: f64) -> (f64, f64) {
        let (width, height) = (self.width as f64, self.height as f64);
        (0.2 * width + 0.3 * time, 0.8 * height - 0.7 * time)
    }

    fn around(&self, x: f64, y: f64) -> f64 {
        let (across, down) = (x / self.width as f64 - 0.5, y / self.height as f64 - 0.5);
        let mut level = self.background * (1.0 + self.gradient * (across + 0.5 * down));
        if self.bar && (10.0..22.0).contains(&x) {
            level *= 0.5;
        }
        level
    }

    /// Brightness at a place.
    fn light(&self, x: f64, y: f64, (cx, cy): (f64, f64), time: f64) -> f64 {
        if let Some(level) = self.on_sphere(x - cx, y - cy) {
            return level;
        }
        let (dx, dy) = self.droplet_at(time);
        if self.droplet > 0.0 && (x - dx).hypot(y - dy) < self.droplet {
            return self.background + self.contrast;
        }
        let mut level = self.around(x, y);
        if self.shadow > 0.0 {
            // soft: it is cast far from the lamp
            let away =
                ((x - cx - 1.2 * self.radius).hypot(y - cy - 0.8 * self.radius) - self.radius) / (0.2 * self.radius);
            level *= 1.0 - self.shadow / (1.0 + (2.0 * away).exp());
        }
        let Some(plate) = self.plate else { return level };
        if self.meniscus > 0.0 && self.in_meniscus(x - cx, y - cy, plate - cy) {
            return self.background + 0.8 * self.contrast;
        }
        if y > plate {
            level *= 0.8;
            if let Some(mirrored) = self.on_sphere(x - cx, 2.0 * plate - y - cy) {
                level += self.mirror * (mirrored - self.background);
            }
        }
        level
    }

    fn on_sphere(&self, dx: f64, dy: f64) -> Option<f64> {
        let (nx, ny) = (dx / self.radius, dy / self.radius);
        let nz2 = 1.0 - nx * nx - ny * ny;
        if nz2 <= 0.0 {
            return None;
        }
        // from the upper left and from the camera's side
        let lit = (-0.35 * nx - 0.5 * ny + 0.79 * nz2.sqrt()).max(0.0);
        let mut level = (self.background + self.contrast) * (1.0 - self.shading + self.shading * lit);
        if self.highlight {
            let away = (nx + 0.25).hypot(ny + 0.35) / 0.12;
            level += 110.0 * (-0.5 * away * away).exp();
        }
        Some(level)
    }

    /// Liquid between the sphere, the plate and a fillet that touches both.
    fn in_meniscus(&self, dx: f64, dy: f64, plate: f64) -> bool {
        let gap = plate - self.radius;
        if !(-0.2 * self.radius..self.meniscus).contains(&gap) || dy > plate {
            return false;
        }
        let fillet = 0.35 * self.radius;
        let height = plate - fillet;
        let across2 = (self.radius + fillet).powi(2) - height * height;
        if across2 <= 0.0 || height <= 0.0 {
            return false;
        }
        let across = across2.sqrt();
        let touches = self.radius / (self.radius + fillet) * height;
        dx.abs() < across && dy > touches && (dx.abs() - across).hypot(dy - height) > fillet
    }
}

impl Picture {
    pub fn bytes(&self) -> Vec<u8> {
        // a cast ends at the largest and the smallest
        self.levels.iter().map(|level| level.round() as u8).collect()
    }

    pub fn words(&self) -> Vec<u16> {
        self.levels.iter().map(|level| (level * 257.0).round() as u16).collect()
    }

    pub fn png(&self, path: &Path) {
        self.encode_png(path, &self.bytes(), ExtendedColorType::L8);
    }

    pub fn png_of_16_bits(&self, path: &Path) {
        let words: Vec<u8> = self.words().iter().flat_map(|word| word.to_ne_bytes()).collect();
        self.encode_png(path, &words, ExtendedColorType::L16);
    }

    /// Grey in every colour, and half transparent.
    pub fn png_of_colours(&self, path: &Path) {
        let pixels: Vec<u8> = self
            .bytes()
            .iter()
            .flat_map(|level| [*level, *level, *level, 128])
            .collect();
        self.encode_png(path, &pixels, ExtendedColorType::Rgba8);
    }

    pub fn jpeg(&self, path: &Path) {
        let file = BufWriter::new(File::create(path).expect("a place for frames"));
        let (width, height) = (self.width as u32, self.height as u32);
        let mut encoder = JpegEncoder::new_with_quality(file, 95);
        let encoded = encoder.encode(&self.bytes(), width, height, ExtendedColorType::L8);
        encoded.expect("a JPEG");
    }

    fn encode_png(&self, path: &Path, bytes: &[u8], colours: ExtendedColorType) {
        let (width, height) = (self.width as u32, self.height as u32);
        image::save_buffer_with_format(path, bytes, width, height, colours, ImageFormat::Png).expect("a PNG");
    }
}

/// Writes pictures as the pages of a TIFF, one after the other, of 8 or of 16 bits.
pub fn tiff(path: &Path, wide: bool, pictures: impl Iterator<Item = impl Borrow<Picture>>) {
    let mut encoder =
        TiffEncoder::new(BufWriter::new(File::create(path).expect("a place for frames"))).expect("a TIFF");
    for picture in pictures {
        let picture = picture.borrow();
        let (width, height) = (picture.width as u32, picture.height as u32);
        if wide {
            encoder
                .write_image::<colortype::Gray16>(width, height, &picture.words())
                .expect("a page");
        } else {
            encoder
                .write_image::<colortype::Gray8>(width, height, &picture.bytes())
                .expect("a page");
        }
    }
}
