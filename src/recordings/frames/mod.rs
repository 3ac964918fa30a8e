//! Finds the sphere in the frames of a recording, to a part of a pixel.
//!
//! The background comes from a sample of the frames, the sphere's radius from the same sample. Then every frame is decoded
//! once: edges vote for centres, the outline about a centre is found along rays, and a circle is fitted to its good arcs. At
//! last, the radius being one for the whole recording, circles of that radius are fitted to the same outlines.
//!
//! | file | job |
//! |---|---|
//! | `decode.rs` | decodes PNG, JPEG and TIFF within limits of size |
//! | `source.rs` | lists the frames of a recording, and says what is wrong with them |
//! | `regions.rs` | parts a picture into regions that belong together |
//! | `background.rs` | says what stands behind the sphere |
//! | `votes.rs` | lets edges vote for centres of discs |
//! | `edge.rs` | finds the outline along rays, to a part of a pixel |
//! | `circle.rs` | fits a circle to the good arcs of an outline |
//! | `sphere.rs` | tells the sphere from its mirror image, and its radius |

mod background;
mod circle;
mod decode;
mod edge;
mod regions;
mod source;
mod sphere;
mod votes;

pub(super) use source::FFMPEG;

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use background::Background;
use circle::median;
use decode::Grey;
use source::Frames;
use sphere::Seeker;

pub use sphere::Sighting;

/// What the frames of a recording show.
#[derive(Debug, Clone, PartialEq)]
pub struct Sightings {
    /// frames in all
    pub frames: usize,
    /// frames in which the sphere is whole and was found, in order
    pub seen: Vec<Sighting>,
    /// frames without: not yet in view, in part outside, or hidden
    pub missed: Vec<usize>,
    /// the sphere's radius, one for the whole recording, px
    pub radius_px: f64,
    /// sd of a pixel from frame to frame, in grey levels of the files
    pub noise: f64,
    /// step of brightness at the sphere's outline, the median over frames, in grey levels of the files
    pub contrast: f64,
}

/// Finds the sphere in every frame of a recording, which falls downwards in them.
///
/// `path` is a folder of PNG, JPEG or TIFF frames of 8 or 16 bits, in order of name (frame2 before frame10), or a TIFF of
/// several pages. `progress` is told how many frames are done, and of how many. The result is the same for any number of
/// threads.
///
/// Positions are good to a few hundredths of a pixel where the sphere moves by less than a quarter of its radius during an
/// exposure, to a few tenths up to half of it; near a whole radius they may be wrong by pixels (`blur_px` tells).
///
/// The sphere is the largest disc that moves, of 4 px in radius or more. A camera that moves, or a recording in which the
/// sphere rests in all frames, is outside of the method.
///
/// Fails where files are not such frames or not of one size, and where no frame shows a sphere; the message names the
/// file and what was expected.
pub fn find_sphere(path: &Path, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Sightings, String> {
    let frames = Frames::open(path)?;
    let first = frames.read(0)?;
    let sample = background::sample_frames(frames.len(), first.levels.len());
    let sample = read_all(&frames, &sample, &first)?;
    let nothing = || {
        format!(
            "{}: no sphere in {} frames; expected a disc that moves, of a contrast of several times the noise",
            path.display(),
            frames.len()
        )
    };
    let background = Background::of(&sample).ok_or_else(nothing)?;
    let radius = match sphere::radius(&sample, &background) {
        Some(radius) => radius,
        None => radius_elsewhere(&frames, &background, &first)?.ok_or_else(nothing)?,
    };
    drop(sample);
    let seeker = Seeker::new(&background, radius);
    let done = AtomicUsize::new(0);
    let all: Vec<usize> = (0..frames.len()).collect();
    let mut outlines = of_each(&frames, &all, &first, |grey| {
        let outline = seeker.outline(&grey);
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, frames.len());
        outline
    })?;
    let shared = sphere::shared(&outlines).ok_or_else(nothing)?;
    sphere::leave_mirror_images_out(&mut outlines);
    let (mut seen, mut missed) = (vec![], vec![]);
    for (frame, outline) in frames.counted().into_iter().zip(&outlines) {
        match outline
            .as_ref()
            .and_then(|outline| seeker.sighting(frame, outline, shared))
        {
            Some(sighting) => seen.push(sighting),
            None => missed.push(frame),
        }
    }
    if seen.is_empty() {
        return Err(nothing());
    }
    let unit = f64::from(background.unit);
    let contrasts = outlines
        .iter()
        .flatten()
        .map(|outline| f64::from(outline.edges.contrast));
    Ok(Sightings {
        frames: frames.len(),
        seen,
        missed,
        radius_px: shared.radius,
        noise: f64::from(background.noise) / unit,
        contrast: median(contrasts).unwrap_or(0.0) / unit,
    })
}

/// A frame that must be like the first.
fn read_like(frames: &Frames, frame: usize, first: &Grey) -> Result<Grey, String> {
    let grey = frames.read(frame)?;
    let refused = |found: &str, expected: &str| {
        let [own, other] = [frame, 0].map(|frame| frames.name(frame));
        Err(format!("{own}: {found}; expected {expected} as in {other}"))
    };
    if (grey.width, grey.height) != (first.width, first.height) {
        let [own, other] = [&grey, first].map(|grey| format!("{} × {}", grey.width, grey.height));
        return refused(&format!("{own} pixels"), &other);
    }
    if grey.unit != first.unit {
        let [own, other] = [&grey, first].map(|grey| if grey.unit == 1 { "16" } else { "8" });
        return refused(&format!("{own} bits"), other);
    }
    Ok(grey)
}

/// What is made of each of some frames, which must be like the first. Of several that cannot be read the first is named.
fn of_each<T: Send>(
    frames: &Frames,
    which: &[usize],
    first: &Grey,
    of: impl Fn(Grey) -> T + Sync,
) -> Result<Vec<T>, String> {
    let mut all = Vec::with_capacity(which.len());
    for lot in which.chunks(decode::at_once(first.levels.len())) {
        let made = lot.par_iter().map(|frame| read_like(frames, *frame, first).map(&of));
        for one in made.collect::<Vec<Result<T, String>>>() {
            all.push(one?);
        }
    }
    Ok(all)
}

fn read_all(frames: &Frames, which: &[usize], first: &Grey) -> Result<Vec<Grey>, String> {
    of_each(frames, which, first, |grey| grey)
}

/// The radius from frames beside the sample, few at once: a short flight may stand between two of the sample.
fn radius_elsewhere(frames: &Frames, background: &Background, first: &Grey) -> Result<Option<f64>, String> {
    /// Most frames that are held at once.
    const FEW: usize = 16;
    let all: Vec<usize> = (0..frames.len()).collect();
    let mut free = vec![];
    for few in all.chunks(decode::at_once(first.levels.len()).min(FEW)) {
        let read = read_all(frames, few, first)?;
        free.extend(sphere::discs(&read.iter().collect::<Vec<_>>(), background));
    }
    Ok(sphere::largest(free))
}
