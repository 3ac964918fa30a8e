//! Draws many standard normals at once, to the digits of an f32, from half as much chance as one at a time takes.
//!
//! A ziggurat of layers of one area V under f(x) = exp(−x²/2): layer i reaches from 0 to x_i, and all of it below
//! x_{i+1} is under the curve, so that most draws cost a product and a comparison. The layer and the place in it come
//! from different bits of a word, without which the draws of a layer would be too regular. Source: Marsaglia & Tsang
//! 2000 (J. Stat. Softw. 5, 8); for the bits Doornik 2005 (An improved ziggurat method to generate normal random
//! samples).

use rand::Rng;

/// As many as a byte distinguishes.
const LAYERS: usize = 256;

/// Where the tail begins; then as many layers of equal area end at the top. The tests hold it to that.
const TAIL: f64 = 3.654_152_885_361_009;

/// Words of chance that are drawn at once.
const WORDS: usize = 256;

/// The layers of the ziggurat.
#[derive(Debug, Clone)]
pub struct Normals {
    /// x_i, from the widest down to 0
    edges: [f64; LAYERS + 1],
    /// f(x_i)
    heights: [f64; LAYERS + 1],
}

fn height(x: f64) -> f64 {
    (-0.5 * x * x).exp()
}

/// V: the lowest layer's rectangle and the tail beside it.
fn area() -> f64 {
    let tail = std::f64::consts::FRAC_PI_2.sqrt() * libm::erfc(TAIL * std::f64::consts::FRAC_1_SQRT_2);
    TAIL * height(TAIL) + tail
}

/// Above 0, at most 1.
fn uniform<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    const STEP: f64 = 1.0 / (1u64 << 53) as f64;
    ((rng.next_u64() >> 11) + 1) as f64 * STEP
}

impl Normals {
    /// Lays the layers.
    pub fn new() -> Normals {
        let area = area();
        let mut edges = [0.0; LAYERS + 1];
        // the lowest layer as wide as if its tail were part of the rectangle
        edges[0] = area / height(TAIL);
        edges[1] = TAIL;
        for layer in 2..LAYERS {
            let below: f64 = edges[layer - 1];
            edges[layer] = (-2.0 * (area / below + height(below)).ln()).sqrt();
        }
        Normals {
            edges,
            heights: edges.map(height),
        }
    }

    /// Fills a slice with independent draws.
    pub fn fill<R: Rng + ?Sized>(&self, rng: &mut R, draws: &mut [f64]) {
        let mut words = [0; 4 * WORDS];
        for draws in draws.chunks_mut(WORDS) {
            let words = &mut words[..4 * draws.len()];
            rng.fill_bytes(words);
            for (draw, word) in draws.iter_mut().zip(words.chunks_exact(4)) {
                let word = u32::from_le_bytes([word[0], word[1], word[2], word[3]]);
                let (layer, x) = self.place(word);
                *draw = if x.abs() < self.edges[usize::from(layer) + 1] {
                    x
                } else {
                    self.outside(layer, x, rng)
                };
            }
        }
    }

    /// A layer and a place in it, to 24 bits and never quite 0.
    #[inline(always)]
    fn place(&self, word: u32) -> (u8, f64) {
        const STEP: f64 = 1.0 / (1u64 << 23) as f64;
        let layer = word as u8;
        let part = (f64::from(word as i32 >> 8) + 0.5) * STEP;
        (layer, part * self.edges[usize::from(layer)])
    }

    /// Decides on a place that may lie above the curve, and draws anew until one does not.
    #[cold]
    fn outside<R: Rng + ?Sized>(&self, mut layer: u8, mut x: f64, rng: &mut R) -> f64 {
        loop {
            let above = usize::from(layer) + 1;
            if x.abs() < self.edges[above] {
                return x;
            }
            if layer == 0 {
                return tail(rng).copysign(x);
            }
            let (low, high) = (self.heights[above - 1], self.heights[above]);
            if low + (high - low) * uniform(rng) < height(x) {
                return x;
            }
            (layer, x) = self.place(rng.next_u32());
        }
    }
}

impl Default for Normals {
    fn default() -> Normals {
        Normals::new()
    }
}

/// A draw beyond the beginning of the tail. Source: Marsaglia 1964 (Technometrics 6, 101).
fn tail<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    loop {
        let beyond = -uniform(rng).ln() / TAIL;
        if -2.0 * uniform(rng).ln() > beyond * beyond {
            return TAIL + beyond;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::likelihood::normal::normal_cdf;
    use crate::seed::stream;

    const DRAWS: usize = 12_000_000;

    /// How far χ² of the counts in bins of equal probability lies from its mean, in its standard deviations.
    fn far(draws: &[f64]) -> f64 {
        const BINS: usize = 100;
        let mut counts = [0.0; BINS];
        for draw in draws {
            counts[((normal_cdf(*draw) * BINS as f64) as usize).min(BINS - 1)] += 1.0;
        }
        let expected = draws.len() as f64 / BINS as f64;
        let squares: f64 = counts.iter().map(|count| (count - expected).powi(2) / expected).sum();
        let freedom = BINS as f64 - 1.0;
        (squares - freedom) / (2.0 * freedom).sqrt()
    }

    fn drawn(normals: &Normals, name: &str) -> Vec<f64> {
        let mut draws = vec![0.0; DRAWS];
        normals.fill(&mut stream(1, name, 0), &mut draws);
        draws
    }

    #[test]
    fn the_layers_end_at_the_top() {
        let normals = Normals::new();
        let last = normals.edges[LAYERS - 1];
        let area_left = last * (1.0 - height(last));
        assert!((area_left / area() - 1.0).abs() < 1e-9, "{area_left} {}", area());
        assert!(normals.edges.windows(2).all(|pair| pair[0] > pair[1]));
    }

    #[test]
    fn draws_are_normal_out_to_the_tail() {
        let name = "draws_are_normal_out_to_the_tail";
        let draws = drawn(&Normals::new(), name);
        assert!(far(&draws).abs() < 4.5, "{}", far(&draws));
        let count = DRAWS as f64;
        for beyond in [3.0, TAIL, 4.0, 4.5] {
            for sign in [-1.0, 1.0] {
                let p = normal_cdf(-beyond);
                let found = draws.iter().filter(|draw| sign * **draw > beyond).count() as f64;
                let z = (found - count * p) / (count * p).sqrt();
                assert!(z.abs() < 4.5, "{found} beyond {}", sign * beyond);
            }
        }
        // neighbours share words of chance where one is drawn anew
        let product: f64 = draws.windows(2).map(|pair| pair[0] * pair[1]).sum();
        assert!(product.abs() / count.sqrt() < 4.5, "{product}");
    }

    #[test]
    fn taking_rectangles_for_what_is_under_the_curve_is_seen() {
        let name = "taking_rectangles_for_what_is_under_the_curve_is_seen";
        let wrong = Normals {
            heights: [0.0; LAYERS + 1],
            ..Normals::new()
        };
        let draws = drawn(&wrong, name);
        assert!(far(&draws) > 20.0, "{}", far(&draws));
    }
}
