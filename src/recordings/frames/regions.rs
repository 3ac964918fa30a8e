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
        let mut two = TwoLevels {
            pixel,
            levels: [usual, other],
            times: [near(usual), near(other)],
            usual: 0,
        };
        if middle(two.times[0]) > middle(two.times[1]) {
            two.levels.reverse();
            two.times.reverse();
            two.usual = 1;
        }
        two
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

/// Pixels that show two levels, region by region, each with the frames of the sample, a bit a frame, in which it shows the
/// background. `levels` are the usual ones, `changed` is in the order of its pixels.
pub(super) fn settle(levels: &[f32], width: usize, changed: &[TwoLevels]) -> Vec<(usize, u64)> {
    let mut region_of = vec![usize::MAX; changed.len()];
    let mut waiting = vec![];
    let mut region: Vec<&TwoLevels> = vec![];
    let find = |pixel: usize| changed.binary_search_by_key(&pixel, |two| two.pixel).ok();
    let mut settled = vec![];
    for (start, seed) in changed.iter().enumerate() {
        if region_of[start] != usize::MAX {
            continue;
        }
        region.clear();
        waiting.push(start);
        region_of[start] = start;
        while let Some(at) = waiting.pop() {
            let two = &changed[at];
            region.push(two);
            for beside in neighbours(two.pixel, width, levels.len(), 1).into_iter().flatten() {
                let Some(next) = find(beside) else { continue };
                if region_of[next] == usize::MAX && belongs(&changed[next], two, seed) {
                    region_of[next] = start;
                    waiting.push(next);
                }
            }
        }
        if region.len() < SMALLEST_REGION {
            continue;
        }
        let inside = |pixel: usize| find(pixel).filter(|at| region_of[*at] == start).map(|at| &changed[at]);
        let changes = |pixel: usize| find(pixel).is_some();
        if let Some(state) = choose(&region, (levels, width), inside, changes) {
            let times = times_of_most(&region, state);
            let pixels = region.iter().map(|two| two.pixel).collect();
            let free = |pixel: usize| !changes(pixel) || inside(pixel).is_some();
            let pixels = with_rim(pixels, width, levels.len(), free);
            settled.extend(pixels.into_iter().map(|pixel| (pixel, times)));
        }
    }
    settled
}

/// The frames in which at least half of the pixels show a state.
fn times_of_most(region: &[&TwoLevels], state: usize) -> u64 {
    let shown = |bit: u32| region.iter().filter(|two| two.times[state] >> bit & 1 == 1).count();
    let most = (0..u64::BITS).filter(|bit| 2 * shown(*bit) >= region.len());
    most.fold(0, |times, bit| times | 1 << bit)
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

/// The state whose picture continues what is beside the region; `None` where nothing tells. `inside` gives the pixels of the
/// region, `changes` says whether a pixel shows two levels.
fn choose<'t>(
    region: &[&TwoLevels],
    (levels, width): (&[f32], usize),
    inside: impl Fn(usize) -> Option<&'t TwoLevels>,
    changes: impl Fn(usize) -> bool,
) -> Option<usize> {
    let mut steps: [Vec<f32>; 2] = [vec![], vec![]];
    let mut usual = [0usize; 2];
    for two in region {
        usual[two.usual] += 1;
        let beside = neighbours(two.pixel, width, levels.len(), 1);
        // a pixel on the outline shows part of both: one step further in is compared with two steps out
        let further = neighbours(two.pixel, width, levels.len(), 3);
        for direction in 0..4 {
            let (Some(out), Some(far)) = (beside[direction], further[direction]) else {
                continue;
            };
            let Some(within) = beside[3 - direction]
                .filter(|_| !changes(out) && !changes(far))
                .and_then(&inside)
            else {
                continue;
            };
            for (state, steps) in steps.iter_mut().enumerate() {
                steps.push((within.levels[state] - levels[far]).abs());
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
