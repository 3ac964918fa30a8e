//! Lists the frames of a recording: a folder of images in order of name, or the pages of a TIFF.

use std::cmp::Ordering;
use std::ffi::OsStr;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use image::ImageFormat;
use tiff::decoder::Decoder;

use super::decode::{self, format_of, Grey};
use crate::files::is_video;

/// Frames below which a background is not told from a sphere.
pub(super) const FEWEST_FRAMES: usize = 5;

/// The one command line that makes frames of a video: each frame once, whatever its rate.
pub(in crate::recordings) const FFMPEG: &str = "mkdir frames && ffmpeg -i FILE -fps_mode passthrough frames/%06d.png";

const EXPECTED: &str = "expected a folder of PNG, JPEG or TIFF frames, or a TIFF of several pages";

/// Names of files that are images, but of a format that is not read.
const OTHER_IMAGES: [&str; 14] = [
    "bmp", "gif", "webp", "jp2", "jxl", "avif", "heic", "dng", "pgm", "ppm", "pnm", "tga", "exr", "b16",
];

type Pages = Decoder<BufReader<File>>;

/// The frames of a recording, none of which is in memory.
pub(super) enum Frames {
    Files(Vec<PathBuf>),
    Pages {
        path: PathBuf,
        count: usize,
        /// readers that know where pages are, as many as are at work at once
        idle: Mutex<Vec<Pages>>,
    },
}

impl Frames {
    /// Of a folder or of a TIFF; fails where there are fewer than five.
    pub fn open(path: &Path) -> Result<Frames, String> {
        let kind = std::fs::metadata(path).map_err(|error| format!("{}: {error}; {EXPECTED}", path.display()))?;
        let frames = if kind.is_dir() {
            of_folder(path)?
        } else {
            of_file(path)?
        };
        let count = frames.len();
        if count < FEWEST_FRAMES {
            let (file, noun) = (path.display(), if count == 1 { "frame" } else { "frames" });
            return Err(format!(
                "{file}: {count} {noun}; expected at least {FEWEST_FRAMES}, some of them before the impact"
            ));
        }
        Ok(frames)
    }

    pub fn len(&self) -> usize {
        match self {
            Frames::Files(paths) => paths.len(),
            Frames::Pages { count, .. } => *count,
        }
    }

    /// How many frame times each comes after the first: by the numbers in the names of files, where one that lacks is a frame
    /// that is missing.
    pub fn counted(&self) -> Vec<usize> {
        let by_name = match self {
            Frames::Files(paths) => counted_by_name(paths),
            Frames::Pages { .. } => None,
        };
        by_name.unwrap_or_else(|| (0..self.len()).collect())
    }

    /// What a message calls a frame.
    pub fn name(&self, frame: usize) -> String {
        match self {
            Frames::Files(paths) => paths[frame].display().to_string(),
            Frames::Pages { path, .. } => format!("{}: page {}", path.display(), frame + 1),
        }
    }

    /// The grey levels of a frame.
    pub fn read(&self, frame: usize) -> Result<Grey, String> {
        let grey = match self {
            Frames::Files(paths) => decode::file(&paths[frame]),
            Frames::Pages { path, idle, .. } => page(path, frame, idle),
        };
        grey.map_err(|problem| format!("{}: {problem}", self.name(frame)))
    }
}

/// Reads a page with an idle reader, which is idle again afterwards.
fn page(path: &Path, frame: usize, idle: &Mutex<Vec<Pages>>) -> Result<Grey, String> {
    let kept = idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
    let mut reader = match kept {
        Some(reader) => reader,
        None => decode::open_tiff(path)?,
    };
    reader
        .seek_to_image(frame)
        .map_err(|error| decode::unreadable("TIFF page", error))?;
    let grey = decode::tiff_page(&mut reader)?;
    idle.lock().unwrap_or_else(PoisonError::into_inner).push(reader);
    Ok(grey)
}

fn of_file(path: &Path) -> Result<Frames, String> {
    let name = path.display();
    match format_of(path) {
        Some(ImageFormat::Tiff) => {}
        Some(_) => return Err(format!("{name}: a single image; {EXPECTED}")),
        None if is_video(path) => return Err(format!("{name}: a video; {EXPECTED}: make frames with `{FFMPEG}`")),
        None => {
            return Err(format!(
                "{name}: not frames; {EXPECTED}; of a video, make frames with `{FFMPEG}`"
            ))
        }
    }
    let mut reader = decode::open_tiff(path).map_err(|problem| format!("{name}: {problem}"))?;
    let mut count = 1;
    while reader.more_images() {
        count += 1;
        let next = reader.next_image();
        next.map_err(|error| format!("{name}: page {count}: {}", decode::unreadable("TIFF page", error)))?;
    }
    if count == 1 {
        return Err(format!("{name}: a TIFF of a single page; {EXPECTED}"));
    }
    Ok(Frames::Pages {
        path: path.to_owned(),
        count,
        idle: Mutex::new(vec![reader]),
    })
}

fn of_folder(folder: &Path) -> Result<Frames, String> {
    let name = folder.display();
    let unreadable = |error: std::io::Error| format!("{name}: {error}; {EXPECTED}");
    let mut found: Vec<(ImageFormat, PathBuf)> = vec![];
    let mut foreign: Vec<PathBuf> = vec![];
    let mut videos: Vec<PathBuf> = vec![];
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        // hidden files are an operating system's
        let hidden = path
            .file_name()
            .is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        if hidden || path.is_dir() {
            continue;
        }
        let ending = path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
        match format_of(&path) {
            Some(format) => found.push((format, path)),
            None if ending.is_some_and(|ending| OTHER_IMAGES.contains(&ending.as_str())) => foreign.push(path),
            None if is_video(&path) => videos.push(path),
            None => {}
        }
    }
    found.sort_by(|(_, a), (_, b)| natural_order(a, b));
    foreign.sort();
    let Some((format, first)) = found.first().cloned() else {
        let holds = match (foreign.first(), videos.first()) {
            (Some(image), _) => format!("{} is of a format that is not read", image.display()),
            (None, Some(video)) => format!("of {} make frames with `{FFMPEG}`", video.display()),
            (None, None) => "no image is in it".to_owned(),
        };
        return Err(format!("{name}: {EXPECTED}; {holds}"));
    };
    let other = found.iter().find(|(other, _)| *other != format).map(|(_, path)| path);
    if let Some(other) = other.or(foreign.first()) {
        return Err(format!(
            "{name}: images of several formats, as {} and {}; expected frames of one format and no other images",
            first.display(),
            other.display()
        ));
    }
    Ok(Frames::Files(found.into_iter().map(|(_, path)| path).collect()))
}

/// By the last number in each name, counted in steps from the first; `None` where these do not go up by one step in most places
/// and by several in the others.
fn counted_by_name(paths: &[PathBuf]) -> Option<Vec<usize>> {
    let number = |path: &PathBuf| -> Option<usize> {
        let stem = path.file_stem()?.to_str()?;
        let end = stem.trim_end_matches(|c: char| !c.is_ascii_digit());
        let start = end.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        end.get(start..)?.parse().ok()
    };
    let numbers: Vec<usize> = paths.iter().map(number).collect::<Option<_>>()?;
    let steps: Vec<usize> = numbers
        .windows(2)
        .map(|pair| pair[1].checked_sub(pair[0]))
        .collect::<Option<_>>()?;
    let step = steps.iter().copied().min().filter(|step| *step > 0)?;
    let usual = steps.iter().filter(|own| **own == step).count();
    let is_counted = 2 * usual > steps.len() && steps.iter().all(|own| own % step == 0);
    is_counted.then(|| numbers.iter().map(|number| (number - numbers[0]) / step).collect())
}

/// The order in which numbers in names are compared as numbers: frame2 stands before frame10.
fn natural_order(one: &Path, other: &Path) -> Ordering {
    // equal but for leading zeros
    natural_key(one).cmp(&natural_key(other)).then_with(|| one.cmp(other))
}

/// The bytes of a name, each number as a zero, how many digits it has and these.
fn natural_key(path: &Path) -> Vec<usize> {
    const ZERO: usize = b'0' as usize;
    let name = path.file_name().map_or(&[][..], OsStr::as_encoded_bytes);
    let mut key = vec![];
    for part in name.chunk_by(|a, b| a.is_ascii_digit() == b.is_ascii_digit()) {
        let bytes = part.iter().map(|byte| usize::from(*byte));
        if part[0].is_ascii_digit() {
            let digits = bytes.skip_while(|byte| *byte == ZERO);
            key.extend([ZERO, digits.clone().count()]);
            key.extend(digits);
        } else {
            key.extend(bytes);
        }
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_lacks_is_a_frame_that_is_missing() {
        let counted = |names: &[&str]| counted_by_name(&names.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(
            counted(&["f07.png", "f08.png", "f11.png", "f12.png"]),
            Some(vec![0, 1, 4, 5])
        );
        assert_eq!(
            counted(&["a_010_x.png", "a_020_x.png", "a_030_x.png"]),
            Some(vec![0, 1, 2])
        );
        // as times in microseconds are
        assert_eq!(counted(&["t100.png", "t351.png", "t603.png", "t850.png"]), None);
        assert_eq!(counted(&["a.png", "b.png", "c.png"]), None);
    }

    #[test]
    fn numbers_in_names_are_compared_as_numbers() {
        let ordered = [
            "a.png",
            "f-1.png",
            "f-2.png",
            "f-010.png",
            "f-10b.png",
            "f-99999999999999999999999.png",
            "f-100000000000000000000000.png",
            "g1x2.png",
            "g1x11.png",
            "g01y.png",
        ];
        let mut sorted: Vec<PathBuf> = ordered.iter().rev().map(PathBuf::from).collect();
        sorted.sort_by(|a, b| natural_order(a, b));
        assert_eq!(sorted, ordered.map(PathBuf::from));
        assert_eq!(natural_order(Path::new("f1"), Path::new("f01")), Ordering::Greater);
        assert_eq!(natural_order(Path::new("f1"), Path::new("f1")), Ordering::Equal);
    }
}
