//! Chooses, of two lasting pictures of a region, the one that continues its surroundings.

/// A pixel that shows two levels, each for a while.
#[derive(Debug, Clone, Copy)]
pub(super) struct TwoLevels {
    pixel: usize,
    /// the level that it shows first, counting the middle of the times, and the one after
    levels: [f32; 2],
    /// frames of the sample with each, a bit a frame
    times: [u64; 2],
    /// which of the two it shows more often
    usual: usize,
}

impl TwoLevels {
    /// Of a pixel with this usual and this other level in such a series.
    pub fn new(pixel: usize, usual: f32, other: f32, series: &[f32], noise: f32) -> TwoLevels {
        let reach = (4.0 * noise).min(0.5 * (usual - other).abs());
        let near = |level: f32| {
            let bits = series.iter().enumerate();
            bits.filter(|(_, value)| (**value - level).abs() <= reach)
                .fold(0u64, |times, (k, _)| times | 1 << (k as u32 % u64::BITS))
        };
        let (of_usual, of_other) = (near(usual), near(other));
        if middle(of_usual) <= middle(of_other) {
            TwoLevels {
                pixel,
                levels: [usual, other],
                times: [of_usual, of_other],
                usual: 0,
            }
        } else {
            TwoLevels {
                pixel,
                levels: [other, usual],
                times: [of_other, of_usual],
                usual: 1,
            }
        }
    }

    /// Frames in which one of two pixels is in its first state and the other in its second.
    fn disagreements(&self, other: &TwoLevels) -> u32 {
        let [early, late] = self.times;
        let [other_early, other_late] = other.times;
        ((early & other_late) | (late & other_early)).count_ones()
    }
}

/// Whether a pixel belongs to a region that grows from a seed: it changed when the pixel beside it did, and not much
/// later than the seed, since a sphere that starts slowly uncovers its place bit by bit.
fn belongs(pixel: &TwoLevels, beside: &TwoLevels, seed: &TwoLevels) -> bool {
    let shorter = seed.times[0].count_ones().min(seed.times[1].count_ones());
    pixel.disagreements(beside) <= 1 && pixel.disagreements(seed) <= shorter / 2
}

/// Mean of the places of a word's bits.
fn middle(times: u64) -> f32 {
    let places = (0..u64::BITS).filter(|bit| times >> bit & 1 == 1);
    places.map(|bit| bit as f32).sum::<f32>() / times.count_ones().max(1) as f32
}

/// Pixels of a region below which it is left at its usual level.
const SMALLEST_REGION: usize = 12;

/// Pairs of pixels across a region's edge that are enough to choose by.
const FEWEST_PAIRS: usize = 8;

/// How much rougher the edge of the usual picture must be for the other to be taken.
const ROUGHER: f32 = 1.25;

/// Pixels about a region whose outline they share, though they show too little of the other state to tell it alone.
const RIM: usize = 3;

/// A pixel and the frames of the sample, a bit a frame, in which it shows the background.
pub(super) struct Shows {
    pub pixel: usize,
    pub times: u64,
}

/// When pixels that show two levels show the background, region by region. `levels` are the usual ones, `changed` is in the
/// order of its pixels.
pub(super) fn settle(levels: &[f32], width: usize, changed: &[TwoLevels]) -> Vec<Shows> {
    let mut region_of = vec![usize::MAX; changed.len()];
    let mut waiting = vec![];
    let mut region: Vec<usize> = vec![];
    let find = |pixel: usize| changed.binary_search_by_key(&pixel, |two| two.pixel).ok();
    let mut settled = vec![];
    for start in 0..changed.len() {
        if region_of.get(start) != Some(&usize::MAX) {
            continue;
        }
        region.clear();
        waiting.push(start);
        region_of[start] = start;
        while let Some(at) = waiting.pop() {
            region.push(at);
            let (Some(two), Some(seed)) = (changed.get(at), changed.get(start)) else {
                continue;
            };
            for beside in neighbours(two.pixel, width, levels.len(), 1).into_iter().flatten() {
                let Some(next) = find(beside) else { continue };
                let joins = region_of.get(next) == Some(&usize::MAX)
                    && changed.get(next).is_some_and(|other| belongs(other, two, seed));
                if joins {
                    region_of[next] = start;
                    waiting.push(next);
                }
            }
        }
        if region.len() < SMALLEST_REGION {
            continue;
        }
        if let Some(state) = choose(&region, start, changed, &region_of, levels, width, &find) {
            let times = times_of_most(region.iter().filter_map(|at| changed.get(*at)), state);
            let pixels = region.iter().filter_map(|at| changed.get(*at)).map(|two| two.pixel);
            let free = |pixel: usize| find(pixel).is_none_or(|at| region_of.get(at) == Some(&start));
            let pixels = with_rim(pixels.collect(), width, levels.len(), free);
            settled.extend(pixels.into_iter().map(|pixel| Shows { pixel, times }));
        }
    }
    settled
}

/// The frames in which at least half of the pixels show a state.
fn times_of_most<'t>(region: impl Iterator<Item = &'t TwoLevels>, state: usize) -> u64 {
    let (mut counts, mut pixels) = ([0usize; u64::BITS as usize], 0);
    for two in region {
        pixels += 1;
        for (bit, count) in counts.iter_mut().enumerate() {
            *count += usize::from(two.times[state] >> bit & 1 == 1);
        }
    }
    let most = counts.iter().enumerate().filter(|(_, count)| 2 * **count >= pixels);
    most.fold(0, |times, (bit, _)| times | 1 << bit)
}

/// A region with the free pixels near it, in their order.
fn with_rim(mut region: Vec<usize>, width: usize, pixels: usize, free: impl Fn(usize) -> bool) -> Vec<usize> {
    for _ in 0..RIM {
        let beside = region
            .iter()
            .flat_map(|pixel| neighbours(*pixel, width, pixels, 1))
            .flatten();
        let beside: Vec<usize> = beside.filter(|pixel| free(*pixel)).collect();
        region.extend(beside);
        region.sort_unstable();
        region.dedup();
    }
    region
}

/// The state whose picture continues what is beside the region; `None` where nothing tells.
fn choose(
    region: &[usize],
    number: usize,
    changed: &[TwoLevels],
    region_of: &[usize],
    levels: &[f32],
    width: usize,
    find: &impl Fn(usize) -> Option<usize>,
) -> Option<usize> {
    let inside = |pixel: usize| find(pixel).filter(|at| region_of.get(*at) == Some(&number));
    let mut steps: [Vec<f32>; 2] = [vec![], vec![]];
    let mut usual = [0usize; 2];
    for two in region.iter().filter_map(|at| changed.get(*at)) {
        usual[two.usual] += 1;
        let beside = neighbours(two.pixel, width, levels.len(), 1);
        // a pixel on the outline shows part of both: one step further in is compared with two steps out
        let further = neighbours(two.pixel, width, levels.len(), 3);
        for direction in 0..4 {
            let (Some(out), Some(far), Some(back)) = (beside[direction], further[direction], beside[3 - direction])
            else {
                continue;
            };
            let (None, None, Some(back)) = (find(out), find(far), inside(back)) else {
                continue;
            };
            let (Some(level), Some(within)) = (levels.get(far), changed.get(back)) else {
                continue;
            };
            for (state, steps) in steps.iter_mut().enumerate() {
                steps.push((within.levels[state] - level).abs());
            }
        }
    }
    if steps[0].len() < FEWEST_PAIRS {
        return None;
    }
    let rough = steps.map(|mut steps| {
        let middle = steps.len() / 2;
        *steps.select_nth_unstable_by(middle, f32::total_cmp).1
    });
    let state = usize::from(usual[1] > usual[0]);
    let other = 1 - state;
    Some(if rough[state] > ROUGHER * rough[other] {
        other
    } else {
        state
    })
}

/// Pixels so many steps to the right, below, above and to the left; opposite ones are mirrored in this order.
fn neighbours(pixel: usize, width: usize, pixels: usize, steps: usize) -> [Option<usize>; 4] {
    let x = pixel % width.max(1);
    let below = pixel + steps * width;
    [
        (x + steps < width).then_some(pixel + steps),
        (below < pixels).then_some(below),
        pixel.checked_sub(steps * width),
        (x >= steps).then(|| pixel - steps),
    ]
}
