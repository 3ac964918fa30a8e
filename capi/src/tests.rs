//! Holds what C cannot look at: that nothing is allocated, that a panic ends here, that no law gains energy.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use super::*;

/// The system's allocator, counting the calls of each thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: everything is handed on to the system's allocator as it came
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: the caller's word, handed on
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's word, handed on
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(of: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    of();
    ALLOCATIONS.with(Cell::get) - before
}

const HEADER: &CStr =
    c"particle,law,dry_k,dry_order,inertial_loss,alpha,beta_m_s,kappa_m2_s2,min_speed_m_s,max_speed_m_s,quotable";
const LINE: &CStr = c"PTFE,impact,0.183,2,0.06,,-0.11,1e-4,0.6,1.8,true";

#[test]
fn no_function_allocates() {
    let (mut law, mut number, mut other) = (NO_LAW, 0.0, 0.0);
    let count = allocations(|| {
        // SAFETY: the pointers are those of variables above
        unsafe {
            assert_eq!(wetcor_law_from_alpha_beta(0.5, -0.1, &mut law), WETCOR_OK);
            assert_eq!(wetcor_law_dry(0.5, 2, &mut law), WETCOR_OK);
            assert_eq!(
                wetcor_law_from_csv(HEADER.as_ptr(), c"x".as_ptr(), &mut law),
                WETCOR_BAD_LINE
            );
            assert_eq!(wetcor_law_from_csv(HEADER.as_ptr(), LINE.as_ptr(), &mut law), WETCOR_OK);
            assert_eq!(wetcor_law_set_range(&mut law, 0.1, 2.0), WETCOR_OK);
            assert_eq!(wetcor_restitution(&law, 1.0, &mut number), WETCOR_OK);
            assert_eq!(wetcor_log_slope(&law, 3.0, &mut number), WETCOR_EXTRAPOLATED);
            assert_eq!(wetcor_threshold_speed(&law, &mut number), WETCOR_OK);
            assert_eq!(wetcor_range(&law, &mut number, &mut other), WETCOR_OK);
        }
        assert!(!wetcor_status_text(-3).is_null() && !wetcor_version().is_null());
    });
    assert_eq!(count, 0);
    // the count counts
    assert_eq!(allocations(|| drop(std::hint::black_box(Box::new(1)))), 1);
}

#[test]
fn a_panic_ends_as_a_status() {
    let nothing: [u8; 0] = [];
    let found = guarded(|| {
        assert_eq!(nothing.len(), 1, "on purpose");
        Ok(())
    });
    assert_eq!(found, Err(WETCOR_INTERNAL));
}

/// A number in 0..1 that looks like chance, the same at every run.
fn fraction(step: u32, of: u32) -> f64 {
    (0.618_033_988_749_894_9 * f64::from(step * 7 + of * of + 1) * f64::from(of + 1).sqrt()).fract()
}

#[test]
fn no_law_that_can_be_made_gains_energy() {
    let mut made = 0;
    for step in 0..20_000 {
        let number = |of: u32, low: f64, high: f64| low + (high - low) * fraction(step, of);
        let (beta, kappa) = (number(1, -1.0, 0.2), number(2, -0.01, 0.05));
        let plateau = match step % 3 {
            0 => Plateau::Constant(number(3, -0.5, 1.5)),
            order => Plateau::OfSpeed {
                dry_k: number(4, -0.2, 1.5),
                order: if order == 1 { Order::First } else { Order::Second },
                loss: number(5, -0.3, 0.9),
            },
        };
        let Ok(law) = wetcor_law::new(LawNumbers { plateau, beta, kappa }) else {
            continue;
        };
        made += 1;
        let v = 10f64.powf(number(6, -4.0, 2.0));
        let (e, status) = law.at(v, |law, v| Some(law.at(v)));
        assert!((0.0..=1.0).contains(&e) && status == WETCOR_OK, "{law:?} {v} {e}");
        assert_eq!(e, Restitution::from(LawNumbers { plateau, beta, kappa }).at(v));
    }
    assert!(made > 5_000 && made < 15_000, "{made}");
}

#[test]
fn no_line_however_broken_is_more_than_refused() {
    let (header, line) = (HEADER.to_bytes(), LINE.to_bytes());
    assert!(line::law(header, line).is_ok());
    let mut refused = 0;
    for at in 0..line.len() {
        for byte in [b',', b'"', b'-', b'e', b'\n', 0xff] {
            let mut broken = line.to_vec();
            if let Some(place) = broken.get_mut(at) {
                *place = byte;
            }
            refused += usize::from(line::law(header, &broken).is_err());
            let _ = line::law(&broken, line);
        }
        let (head, tail) = line.split_at(at);
        assert!(line::law(header, head).is_err());
        assert!(at == 0 || at < 5 || line::law(header, tail).is_err());
    }
    assert!(refused > line.len(), "{refused}");
}

/// A report's own lines, which the program writes: each has the threshold that stands in it.
#[test]
fn the_laws_of_a_report_are_read() {
    let table = include_str!("../../reports/mueller2016/laws.csv");
    let mut lines = table.lines();
    let header = lines.next().unwrap_or_default();
    let place = header.split(',').position(|name| name == "threshold_speed_m_s");
    let mut read = 0;
    for line in lines {
        let (mut law, mut found) = (NO_LAW, f64::NAN);
        // no zero stands in a table: an empty text would be refused below
        let [named, row] = [header, line].map(|text| std::ffi::CString::new(text).unwrap_or_default());
        // SAFETY: both texts end in a zero, the other pointers are those of variables above
        let status = unsafe { wetcor_law_from_csv(named.as_ptr(), row.as_ptr(), &mut law) };
        assert_eq!(status, WETCOR_OK, "{line}");
        // SAFETY: the pointers are those of variables above
        let status = unsafe { wetcor_threshold_speed(&law, &mut found) };
        assert_eq!(status, WETCOR_OK, "{line}");
        let expected = place.and_then(|place| line.split(',').nth(place)?.parse::<f64>().ok());
        assert!(
            expected.is_some_and(|v| (v - found).abs() <= 1e-12 * v),
            "{line}: {found}"
        );
        read += 1;
    }
    assert_eq!(read, 56);
}

#[test]
fn the_version_is_that_of_the_program() {
    let version = |manifest: &str| {
        manifest
            .lines()
            .find(|line| line.starts_with("version = "))
            .map(str::to_owned)
    };
    let ours = version(include_str!("../Cargo.toml"));
    assert!(ours.is_some());
    assert_eq!(ours, version(include_str!("../../Cargo.toml")));
}
