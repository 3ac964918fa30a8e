//! Limits the replicates to what is held at once, and says where that makes them fewer.

use crate::findings::notices;
use crate::notice::Notice;

/// Replicates of all fits together that are held at once: 2.4 GB.
pub const MOST_HELD: usize = 100_000_000;

/// How many replicates are made of so many fits where a number is wanted: no more than are held at once.
pub(super) fn affordable_replicates(wanted: u64, fits: usize) -> usize {
    let wanted = usize::try_from(wanted).unwrap_or(usize::MAX);
    wanted.min(MOST_HELD / fits.max(1)).max(1)
}

/// Says that fewer replicates were made than the scene asks for; `None` where they were not.
pub(super) fn fewer_replicates_notice(wanted: u64, made: usize, fits: usize) -> Option<Notice> {
    (made as u64 != wanted).then(|| {
        let text = format!(
            "[bootstrap] replicates: found {wanted}, of {fits} fits; made {made}, since at most {MOST_HELD} replicates of \
             all fits together are held at once"
        );
        let next = format!("set it to at most {made}, or fit fewer series in one scene");
        notices::BOOTSTRAP_FEWER_REPLICATES.with_next_step(made, text, next)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_replicates_are_made_than_are_held() {
        // the largest number a scene may ask for, of as many fits as the published example has
        assert_eq!(affordable_replicates(1_000_000, 88), 1_000_000);
        assert_eq!(affordable_replicates(1_000_000, 1000), 100_000);
        assert_eq!(affordable_replicates(10_000, 20_000), 5000);
        assert_eq!(affordable_replicates(10_000, usize::MAX), 1);
        assert_eq!(fewer_replicates_notice(10_000, 10_000, 88), None);
        let notice = fewer_replicates_notice(10_000, 5000, 20_000).expect("fewer");
        assert!(notice
            .text
            .starts_with("[bootstrap] replicates: found 10000, of 20000 fits; made 5000, since at most"));
    }
}
