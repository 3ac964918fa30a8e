//! Gives the laws e_n(v) of [`physics`] to C and to every code that can call C.
//!
//! The header `include/wetcor.h` is made of this file by cbindgen; a test holds the two equal. The only place of the
//! project with `unsafe`: a pointer from C is read or written as a whole, wherever it is not null, and no reference
//! is made of it, so that a caller's pointers may overlap and need not be aligned.
//!
//! Nothing unwinds into C: what is called a collision has nothing that can panic, neither an index nor a slice nor an
//! `unwrap`; reading a line of a table stands behind `catch_unwind`. Nothing is allocated, and there is no state that
//! threads could share.

// the names are those that C sees
#![allow(non_camel_case_types)]
#![allow(
    clippy::missing_safety_doc,
    reason = "what a caller owes is the same for all, and the header says it once"
)]
#![deny(missing_docs, unsafe_op_in_unsafe_fn, clippy::undocumented_unsafe_blocks)]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

mod line;

use std::ffi::{c_char, c_int, CStr};
use std::panic::{catch_unwind, AssertUnwindSafe};

use physics::physics::{LawNumbers, Order, Plateau, Restitution};

/// What a function answers: 0, positive where there is an answer with something to know, negative where there is none.
///
/// Where there is none, a number to be written is NaN and a law to be made is one that every function refuses.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum wetcor_status {
    /// it is answered
    WETCOR_OK = 0,
    /// it is answered, at a speed outside those of the runs behind the law
    WETCOR_EXTRAPOLATED = 1,
    /// the law is made, from a fit that is not to be quoted
    WETCOR_NOT_QUOTABLE = 2,
    /// a pointer is null
    WETCOR_BAD_POINTER = -1,
    /// the law was not made by this library
    WETCOR_BAD_LAW = -2,
    /// the speed is not a finite number above zero, of 2.3e-308 at least
    WETCOR_BAD_SPEED = -3,
    /// a number is not finite or beyond what lets no rebound gain energy, or an order or a range is none
    WETCOR_BAD_NUMBER = -4,
    /// nothing rebounds at this speed, so that there is no slope
    WETCOR_NO_REBOUND = -5,
    /// the header lacks a column
    WETCOR_MISSING_COLUMN = -6,
    /// the line is not one of this header, or a cell of it cannot be read
    WETCOR_BAD_LINE = -7,
    /// a fault of this library
    WETCOR_INTERNAL = -8,
}

use wetcor_status::*;

/// A law e_n(v). To be copied, sent and kept as it is: 56 bytes without pointers. Its fields are not for callers.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct wetcor_law {
    /// tells a law that was made from one that was not
    pub tag: u32,
    /// order of the dry law taken at the impact speed; 0 where e_dry is in `constant`
    pub dry_order: u32,
    /// k of the dry law, (m/s)^(-1/5)
    pub dry_k: f64,
    /// alpha, or where dry_order is not 0 what the liquid's inertia takes
    pub constant: f64,
    /// m/s
    pub beta: f64,
    /// m^2/s^2
    pub kappa: f64,
    /// lowest speed of the runs, m/s
    pub min_speed: f64,
    /// highest speed of the runs, m/s
    pub max_speed: f64,
}

/// "wetc"; a law with other fields gets another.
const TAG: u32 = 0x7765_7463;

/// What is written where no law could be made.
const NO_LAW: wetcor_law = wetcor_law {
    tag: 0,
    dry_order: 0,
    dry_k: f64::NAN,
    constant: f64::NAN,
    beta: f64::NAN,
    kappa: f64::NAN,
    min_speed: f64::NAN,
    max_speed: f64::NAN,
};

impl wetcor_law {
    /// The law with these numbers, of runs at any speed; refused where a number is not finite or a rebound could gain
    /// energy: with what is let through, 0 ≤ e ≤ 1 at every speed.
    fn new(numbers: LawNumbers) -> Result<wetcor_law, wetcor_status> {
        let (dry_order, dry_k, constant) = match numbers.plateau {
            Plateau::Constant(alpha) => (0, 0.0, alpha),
            Plateau::OfSpeed { dry_k, order, loss } => {
                let order = match order {
                    Order::First => 1,
                    Order::Second => 2,
                };
                (order, dry_k, loss)
            }
        };
        let gains = match numbers.plateau {
            Plateau::Constant(alpha) => alpha > 1.0,
            Plateau::OfSpeed { loss, .. } => loss < 0.0,
        };
        let LawNumbers { beta, kappa, .. } = numbers;
        let finite = [dry_k, constant, beta, kappa].iter().all(|number| number.is_finite());
        if !finite || gains || dry_k < 0.0 || beta > 0.0 || kappa < 0.0 {
            return Err(WETCOR_BAD_NUMBER);
        }
        Ok(wetcor_law {
            tag: TAG,
            dry_order,
            dry_k,
            constant,
            beta,
            kappa,
            min_speed: 0.0,
            max_speed: f64::INFINITY,
        })
    }

    /// The same of runs at these speeds, m/s.
    fn with_range(self, min_speed: f64, max_speed: f64) -> Result<wetcor_law, wetcor_status> {
        if min_speed >= 0.0 && min_speed <= max_speed && min_speed.is_finite() {
            Ok(wetcor_law {
                min_speed,
                max_speed,
                ..self
            })
        } else {
            Err(WETCOR_BAD_NUMBER)
        }
    }

    /// What is asked of its numbers, or something else where it is no law.
    ///
    /// A law of each form has code of its own, so that a call looks at the form once.
    #[inline(always)]
    fn ask<T>(&self, otherwise: T, of: impl Fn(LawNumbers) -> T) -> T {
        let numbers = |plateau| LawNumbers {
            plateau,
            beta: self.beta,
            kappa: self.kappa,
        };
        let of_speed = |order| Plateau::OfSpeed {
            dry_k: self.dry_k,
            order,
            loss: self.constant,
        };
        match (self.tag, self.dry_order) {
            (TAG, 0) => of(numbers(Plateau::Constant(self.constant))),
            (TAG, 1) => of(numbers(of_speed(Order::First))),
            (TAG, 2) => of(numbers(of_speed(Order::Second))),
            _ => otherwise,
        }
    }

    /// What is asked of the law at a speed, `None` where there is no rebound.
    ///
    /// Not a `Result`, which took a nanosecond to put together and to take apart.
    #[inline(always)]
    fn at(&self, v: f64, of: impl Fn(Restitution, f64) -> Option<f64>) -> Answer {
        // whether it is finite, above zero and normal, in one comparison; of others 1/v could be infinite
        if !(f64::MIN_POSITIVE.to_bits()..f64::INFINITY.to_bits()).contains(&v.to_bits()) {
            return (f64::NAN, WETCOR_BAD_SPEED);
        }
        self.ask((f64::NAN, WETCOR_BAD_LAW), |numbers| {
            match of(Restitution::from(numbers), v) {
                None => (f64::NAN, WETCOR_NO_REBOUND),
                Some(value) if v >= self.min_speed && v <= self.max_speed => (value, WETCOR_OK),
                Some(value) => (value, WETCOR_EXTRAPOLATED),
            }
        })
    }
}

/// A number for C with its status, NaN where there is none.
type Answer = (f64, wetcor_status);

/// The order of the dry law that C calls 1 or 2.
fn order(order: c_int) -> Result<Order, wetcor_status> {
    match order {
        1 => Ok(Order::First),
        2 => Ok(Order::Second),
        _ => Err(WETCOR_BAD_NUMBER),
    }
}

/// Writes a value to where C wants it and gives its status. Safe where `place` is null or may be written.
#[inline(always)]
unsafe fn write<T>(place: *mut T, (value, status): (T, wetcor_status)) -> wetcor_status {
    if place.is_null() {
        return WETCOR_BAD_POINTER;
    }
    // SAFETY: not null, and that it may be written is the caller's word; a packed struct of the caller may hold it
    unsafe { place.write_unaligned(value) };
    status
}

/// A copy of what C points to; `None` where it is null. Safe where `place` is null or may be read.
#[inline(always)]
unsafe fn read(place: *const wetcor_law) -> Option<wetcor_law> {
    if place.is_null() {
        return None;
    }
    // SAFETY: not null, and that it may be read is the caller's word; every pattern of bits is one of these structs
    Some(unsafe { place.read_unaligned() })
}

/// Writes what is asked of a law. Safe where each pointer is null or may be read or written.
#[inline(always)]
unsafe fn answer(law: *const wetcor_law, place: *mut f64, of: impl FnOnce(wetcor_law) -> Answer) -> wetcor_status {
    // SAFETY: the caller's pointers, as `read` and `write` ask for
    unsafe {
        match read(law) {
            Some(law) => write(place, of(law)),
            None => write(place, (f64::NAN, WETCOR_BAD_POINTER)),
        }
    }
}

/// Hands a law to C.
unsafe fn make(law: *mut wetcor_law, made: Result<wetcor_law, wetcor_status>) -> wetcor_status {
    let made = made.map_or_else(|status| (NO_LAW, status), |law| (law, WETCOR_OK));
    // SAFETY: the caller's pointer, as `write` asks for
    unsafe { write(law, made) }
}

/// A panic as a status, so that it ends here.
fn guarded<T>(read: impl FnOnce() -> Result<T, wetcor_status>) -> Result<T, wetcor_status> {
    // what is left half done by a panic is not looked at again
    catch_unwind(AssertUnwindSafe(read)).unwrap_or(Err(WETCOR_INTERNAL))
}

/// Makes e = sqrt(alpha + beta/v), beta in m/s. alpha up to 1, beta up to 0.
#[no_mangle]
pub unsafe extern "C" fn wetcor_law_from_alpha_beta(alpha: f64, beta: f64, law: *mut wetcor_law) -> wetcor_status {
    // SAFETY: the pointer is handed on as it is
    unsafe { wetcor_law_reference(alpha, beta, 0.0, law) }
}

/// Makes e^2 = alpha + beta/v - kappa/v^2, beta in m/s, kappa in m^2/s^2: `reference` in column `law` of laws.csv.
/// alpha up to 1, beta up to 0, kappa from 0.
#[no_mangle]
pub unsafe extern "C" fn wetcor_law_reference(
    alpha: f64,
    beta: f64,
    kappa: f64,
    law: *mut wetcor_law,
) -> wetcor_status {
    let plateau = Plateau::Constant(alpha);
    // SAFETY: the caller's pointer, as `make` asks for
    unsafe { make(law, wetcor_law::new(LawNumbers { plateau, beta, kappa })) }
}

/// Makes e^2 = e_dry(v)^2 - inertial_loss + beta/v - kappa/v^2, e_dry = 1 - k v^(1/5), with + (3/5) k^2 v^(2/5) where
/// dry_order is 2, not 1: `impact` in laws.csv. dry_k in (m/s)^(-1/5), from 0; inertial_loss and kappa from 0, beta up to 0.
#[no_mangle]
pub unsafe extern "C" fn wetcor_law_impact(
    dry_k: f64,
    dry_order: c_int,
    inertial_loss: f64,
    beta: f64,
    kappa: f64,
    law: *mut wetcor_law,
) -> wetcor_status {
    let made = order(dry_order).and_then(|order| {
        let loss = inertial_loss;
        let plateau = Plateau::OfSpeed { dry_k, order, loss };
        wetcor_law::new(LawNumbers { plateau, beta, kappa })
    });
    // SAFETY: the caller's pointer, as `make` asks for
    unsafe { make(law, made) }
}

/// Makes e = 1 - k v^(1/5), with + (3/5) k^2 v^(2/5) where dry_order is 2, not 1: `dry` in laws.csv.
#[no_mangle]
pub unsafe extern "C" fn wetcor_law_dry(dry_k: f64, dry_order: c_int, law: *mut wetcor_law) -> wetcor_status {
    let made = order(dry_order).and_then(|order| wetcor_law::new(LawNumbers::dry(dry_k, order)));
    // SAFETY: the caller's pointer, as `make` asks for
    unsafe { make(law, made) }
}

/// Makes the law of a line of laws.csv, whose first line is the header; a line end may stand at either's end.
/// Columns are found by their names, numbers have a decimal point whatever the locale.
/// WETCOR_NOT_QUOTABLE: the law is made, from a fit that is not to be quoted.
#[no_mangle]
pub unsafe extern "C" fn wetcor_law_from_csv(
    header: *const c_char,
    line: *const c_char,
    law: *mut wetcor_law,
) -> wetcor_status {
    let made = if header.is_null() || line.is_null() {
        Err(WETCOR_BAD_POINTER)
    } else {
        // SAFETY: not null; that they end in a zero byte and stay as they are during the call is the caller's word
        let (header, line) = unsafe { (CStr::from_ptr(header), CStr::from_ptr(line)) };
        guarded(|| line::law(header.to_bytes(), line.to_bytes()))
    };
    // SAFETY: the caller's pointer, as `write` asks for
    unsafe { write(law, made.unwrap_or_else(|status| (NO_LAW, status))) }
}

/// Sets the speeds of the runs behind a law, m/s; answers outside are then WETCOR_EXTRAPOLATED. 0 <= min <= max.
/// A law made from numbers has 0 and infinity. Where it fails the law is left as it was.
#[no_mangle]
pub unsafe extern "C" fn wetcor_law_set_range(law: *mut wetcor_law, min_speed: f64, max_speed: f64) -> wetcor_status {
    // SAFETY: the caller's pointer, as `read` asks for
    let made = match unsafe { read(law) } {
        None => Err(WETCOR_BAD_POINTER),
        Some(law) => law.ask(Err(WETCOR_BAD_LAW), |_| law.with_range(min_speed, max_speed)),
    };
    match made {
        // SAFETY: the caller's pointer, as `make` asks for
        Ok(_) => unsafe { make(law, made) },
        Err(status) => status,
    }
}

/// Writes e_n at an impact speed v, m/s; 0 where nothing rebounds.
#[no_mangle]
pub unsafe extern "C" fn wetcor_restitution(law: *const wetcor_law, v: f64, e: *mut f64) -> wetcor_status {
    // SAFETY: the caller's pointers, as `answer` asks for
    unsafe { answer(law, e, |law| law.at(v, |law, v| Some(law.at(v)))) }
}

/// Writes d ln e / d ln v at an impact speed v, m/s; WETCOR_NO_REBOUND where nothing rebounds.
#[no_mangle]
pub unsafe extern "C" fn wetcor_log_slope(law: *const wetcor_law, v: f64, slope: *mut f64) -> wetcor_status {
    // SAFETY: the caller's pointers, as `answer` asks for
    unsafe { answer(law, slope, |law| law.at(v, |law, v| law.log_slope(v))) }
}

/// Writes the speed below which nothing rebounds, m/s: 0 where everything does, infinity where nothing does.
#[no_mangle]
pub unsafe extern "C" fn wetcor_threshold_speed(law: *const wetcor_law, v: *mut f64) -> wetcor_status {
    let threshold = |law: wetcor_law| law.ask((f64::NAN, WETCOR_BAD_LAW), |law| (law.threshold_speed(), WETCOR_OK));
    // SAFETY: the caller's pointers, as `answer` asks for
    unsafe { answer(law, v, threshold) }
}

/// Writes the lowest and the highest speed of the runs behind a law, m/s: 0 and infinity where they are not known.
#[no_mangle]
pub unsafe extern "C" fn wetcor_range(
    law: *const wetcor_law,
    min_speed: *mut f64,
    max_speed: *mut f64,
) -> wetcor_status {
    let bound = |law: wetcor_law, bound: f64| law.ask((f64::NAN, WETCOR_BAD_LAW), |_| (bound, WETCOR_OK));
    // SAFETY: the caller's pointers, as `answer` asks for
    unsafe {
        let lowest = answer(law, min_speed, |law| bound(law, law.min_speed));
        let highest = answer(law, max_speed, |law| bound(law, law.max_speed));
        if lowest == WETCOR_OK {
            highest
        } else {
            lowest
        }
    }
}

/// What a status means, in English, for as long as the program runs; also of a number that is none.
#[no_mangle]
pub extern "C" fn wetcor_status_text(status: c_int) -> *const c_char {
    const ALL: [(wetcor_status, &CStr); 11] = [
        (WETCOR_OK, c"answered"),
        (
            WETCOR_EXTRAPOLATED,
            c"answered, outside the speeds of the runs behind the law",
        ),
        (
            WETCOR_NOT_QUOTABLE,
            c"the law is made, from a fit that is not to be quoted",
        ),
        (WETCOR_BAD_POINTER, c"a pointer is null"),
        (WETCOR_BAD_LAW, c"the law was not made by this library"),
        (
            WETCOR_BAD_SPEED,
            c"the speed is not a finite number above zero, of 2.3e-308 at least",
        ),
        (
            WETCOR_BAD_NUMBER,
            c"a number of the law is not finite or would let a rebound gain energy, or an order or a range is none",
        ),
        (
            WETCOR_NO_REBOUND,
            c"nothing rebounds at this speed, so that there is no slope",
        ),
        (
            WETCOR_MISSING_COLUMN,
            c"the header of the table lacks a column that the law needs",
        ),
        (
            WETCOR_BAD_LINE,
            c"the line is not one of this header, or a cell of it cannot be read",
        ),
        (WETCOR_INTERNAL, c"a fault of this library; please report it"),
    ];
    let mut texts = ALL.iter().filter(|(known, _)| *known as c_int == status);
    texts
        .next()
        .map_or(c"no status of this library", |(_, text)| text)
        .as_ptr()
}

/// The version of the library, such as 0.2.0, for as long as the program runs.
#[no_mangle]
pub extern "C" fn wetcor_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

#[cfg(test)]
mod tests;
