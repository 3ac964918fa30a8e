//! Decodes a frame to grey levels, within limits of size.

use std::fmt::Display;
use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::Path;

use image::codecs::{jpeg::JpegDecoder, png::PngDecoder};
use image::{ImageDecoder, ImageFormat, ImageResult};
use tiff::decoder::{Decoder, DecodingResult};
use tiff::TiffError;

use crate::error::Error;
use crate::files::{self, Input};

/// Most frames that are at work at once; between two such lots it is looked whether one could not be read.
const MOST_AT_ONCE: usize = 256;

/// Pixels that are at work at once: a decoder and the search take up to twenty bytes a pixel.
const PIXELS_AT_ONCE: usize = 1 << 25;

/// Frames of so many pixels that are at work at once, however many threads there are.
pub(super) fn at_once(pixels: usize) -> usize {
    (PIXELS_AT_ONCE / pixels.max(1)).clamp(1, MOST_AT_ONCE)
}

/// Pixels of the largest frame that is read.
const MOST_PIXELS: u64 = 1 << 25;

/// Bytes of the largest file of one frame that is read: no format needs more than eight a pixel and a header.
const MOST_BYTES: u64 = 9 * MOST_PIXELS;

/// Bytes that a decoder may ask for.
const MOST_DECODED: u64 = 8 * MOST_PIXELS;

/// The format of a frame, by the name of its file; `None` of one that is not read.
pub(super) fn format_of(path: &Path) -> Option<ImageFormat> {
    let format = ImageFormat::from_path(path).ok()?;
    matches!(format, ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Tiff).then_some(format)
}

/// A frame in grey.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grey {
    pub width: usize,
    pub height: usize,
    /// Row by row, white at 65,535 whatever the file's depth.
    pub levels: Vec<u16>,
    /// What a grey level of the file is here: 256 with 8 bits, 1 with 16.
    pub unit: u16,
}

/// Reads the only image of a file.
pub(super) fn file(path: &Path) -> Result<Grey, String> {
    let format = format_of(path);
    if format == Some(ImageFormat::Tiff) {
        let mut reader = open_tiff(path)?;
        if reader.more_images() {
            return Err("a TIFF of several pages in a folder; expected one page a file, or that file alone".to_owned());
        }
        return tiff_page(&mut reader);
    }
    let (file, size) = open(path)?;
    if size > MOST_BYTES {
        return Err(format!("{size} bytes; expected a frame of at most {MOST_BYTES}"));
    }
    let bytes = files::read_file(&file, size, path, MOST_BYTES, READ).map_err(reason)?;
    if format == Some(ImageFormat::Png) {
        let mut limits = image::Limits::no_limits();
        limits.max_alloc = Some(MOST_DECODED);
        image(PngDecoder::with_limits(Cursor::new(&bytes), limits), "PNG image")
    } else {
        image(JpegDecoder::new(Cursor::new(&bytes)), "JPEG image")
    }
}

/// Says that an image of a kind is damaged.
pub(super) fn unreadable(kind: &str, error: impl Display) -> String {
    format!("not a {kind} that can be read ({error}); expected a whole one")
}

/// What is being done, as a verb.
const READ: &str = "read a frame";

/// Opens a regular file, with its length: each frame is read more than once, which a pipe cannot be.
fn open(path: &Path) -> Result<(File, u64), String> {
    match files::open(path, READ).map_err(reason)? {
        Input::File(file, length) => Ok((file, length)),
        Input::Pipe(_) => Err("found a pipe, expected a regular file".to_owned()),
    }
}

/// Why a file cannot be read, without its name, which the message begins with.
fn reason(error: Error) -> String {
    match error {
        Error::Io { source, .. } => source.to_string(),
        other => other.to_string(),
    }
}

fn image<D: ImageDecoder>(decoder: ImageResult<D>, kind: &str) -> Result<Grey, String> {
    let decoder = decoder.map_err(|error| unreadable(kind, error))?;
    let (width, height) = decoder.dimensions();
    check_size(width, height)?;
    let colour = decoder.color_type();
    let each = usize::from(colour.channel_count());
    let wide = match usize::from(colour.bytes_per_pixel()) / each {
        1 => false,
        2 => true,
        _ => return Err(format!("pixels are {colour:?}; expected grey or RGB of 8 or 16 bits")),
    };
    let mut decoded = vec![0u8; decoder.total_bytes() as usize];
    let read = decoder.read_image(&mut decoded);
    read.map_err(|error| unreadable(kind, error))?;
    if wide {
        // the decoder leaves samples in the order of this machine's bytes
        let pairs = decoded.as_chunks::<2>().0.iter();
        let words = pairs.map(|pair| u16::from_ne_bytes(*pair));
        grey((width, height), words, each, 1)
    } else {
        grey((width, height), decoded.into_iter().map(u16::from), each, 256)
    }
}

/// A reader of a TIFF's pages.
pub(super) fn open_tiff(path: &Path) -> Result<Decoder<BufReader<File>>, String> {
    let (file, _) = open(path)?;
    let mut limits = tiff::decoder::Limits::default();
    limits.decoding_buffer_size = MOST_DECODED as usize;
    limits.intermediate_buffer_size = MOST_DECODED as usize;
    Decoder::new(BufReader::new(file))
        .map(|reader| reader.with_limits(limits))
        .map_err(|error| unreadable("TIFF image", error))
}

/// The page a reader stands at.
pub(super) fn tiff_page(reader: &mut Decoder<BufReader<File>>) -> Result<Grey, String> {
    let unreadable = |error: TiffError| unreadable("TIFF page", error);
    let (width, height) = reader.dimensions().map_err(unreadable)?;
    check_size(width, height)?;
    let each = match reader.colortype().map_err(unreadable)? {
        tiff::ColorType::Gray(_) => 1,
        tiff::ColorType::GrayA(_) => 2,
        tiff::ColorType::RGB(_) => 3,
        tiff::ColorType::RGBA(_) => 4,
        other => return Err(format!("pixels are {other:?}; expected grey or RGB of 8 or 16 bits")),
    };
    match reader.read_image().map_err(unreadable)? {
        DecodingResult::U8(bytes) => grey((width, height), bytes.into_iter().map(u16::from), each, 256),
        DecodingResult::U16(words) => grey((width, height), words.into_iter(), each, 1),
        _ => Err("samples are neither of 8 nor of 16 bits; expected grey or RGB of 8 or 16 bits".to_owned()),
    }
}

/// A frame by the samples of its pixels, of which `each` pixel has so many: one or two of grey, three or four of colours. They
/// become luminance of Rec. 709; transparency, the second or fourth, says nothing of light.
fn grey(
    (width, height): (u32, u32),
    mut samples: impl Iterator<Item = u16>,
    each: usize,
    unit: u16,
) -> Result<Grey, String> {
    /// Parts of 65,536 that red, green and blue have in the luminance.
    const PARTS: [u64; 3] = [13_933, 46_871, 4_732];
    let (width, height) = (width as usize, height as usize);
    let mut levels = Vec::with_capacity(width * height);
    match each {
        1 | 2 => levels.extend(samples.step_by(each).map(|level| level * unit)),
        _ => {
            while let (Some(red), Some(green), Some(blue)) = (samples.next(), samples.next(), samples.next()) {
                let sum = PARTS[0] * u64::from(red) + PARTS[1] * u64::from(green) + PARTS[2] * u64::from(blue);
                levels.push(((sum * u64::from(unit)) >> 16) as u16);
                if each > 3 {
                    samples.next();
                }
            }
        }
    }
    if levels.len() != width * height {
        return Err(format!("{} pixels; expected {width} × {height}", levels.len()));
    }
    Ok(Grey {
        width,
        height,
        levels,
        unit,
    })
}

fn check_size(width: u32, height: u32) -> Result<(), String> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 || pixels > MOST_PIXELS {
        return Err(format!(
            "{width} × {height} pixels; expected from 1 to {MOST_PIXELS} pixels a frame"
        ));
    }
    Ok(())
}
