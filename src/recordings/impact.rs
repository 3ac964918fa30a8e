//! Computes the speeds of an impact from the flights before and after it, with their errors.
//!
//! Symbols: g the shared gravity, of variance V; a flight y = c + u x − g q(x), c and u with errors of their own; t the time
//! at which both flights are at one height, which is that of the contact: v = −ẏ of the one there, v_r = ẏ of the other.
//! Where the sphere stayed, v is that at the height it rests at. All errors are to first order.

use serde::Serialize;

use super::gravity::Gravity;
use super::parabola::Parabola;

/// Speeds at the contact, with their errors.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ContactSpeeds {
    /// when, in s
    pub time: f64,
    /// the height there, in the unit of the track
    pub height: f64,
    /// standard deviation of the height
    pub height_sd: f64,
    /// v
    pub impact_speed: f64,
    /// standard deviation of v
    pub impact_speed_sd: f64,
    /// v_r; 0 where it stayed
    pub rebound_speed: f64,
    /// standard deviation of v_r; 0 where it stayed
    pub rebound_speed_sd: f64,
    /// correlation of their errors
    pub correlation: f64,
}

impl ContactSpeeds {
    /// With an error of one cause besides, of which these are standard deviations in v and v_r; equal signs move both one way.
    pub(super) fn with_error_along(self, [v, v_r]: [f64; 2]) -> ContactSpeeds {
        let (sd, sd_r) = (self.impact_speed_sd.hypot(v), self.rebound_speed_sd.hypot(v_r));
        let covariance = self.correlation * self.impact_speed_sd * self.rebound_speed_sd + v * v_r;
        let correlation = covariance / (sd * sd_r);
        ContactSpeeds {
            impact_speed_sd: sd,
            rebound_speed_sd: sd_r,
            correlation: usable(correlation),
            ..self
        }
    }
}

/// A correlation without what rounding adds; 0 where one of both has no error.
fn usable(correlation: f64) -> f64 {
    if correlation.is_finite() {
        correlation.clamp(-1.0, 1.0)
    } else {
        0.0
    }
}

/// A height with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Level {
    pub height: f64,
    pub sd: f64,
}

/// What a speed moves by with the errors that are independent: c and u of both flights, and g.
type Slopes = [f64; 5];

fn covariance(one: &Slopes, other: &Slopes, variances: &[f64; 5]) -> f64 {
    let products = one.iter().zip(other).zip(variances);
    products.map(|((a, b), variance)| a * b * variance).sum()
}

/// Variances of c and u of a flight with g known, where positions scatter by σ.
fn variances(flight: &Parabola, sigma: f64) -> [f64; 2] {
    [flight.frames as f64, flight.sum_of_squares].map(|sum| sigma * sigma / sum)
}

/// The speeds where two flights meet, of which positions scatter by σ; `None` where they do not.
pub(super) fn rebound(a: &Parabola, b: &Parabola, sigma: f64, gravity: Gravity) -> Option<ContactSpeeds> {
    let acceleration = -gravity.value;
    // the difference of two parabolas of one acceleration is a straight line
    let gain = b.velocity_under(acceleration, b.time) - a.velocity_under(acceleration, b.time);
    let gap = b.height_under(acceleration, b.time) - a.height_under(acceleration, b.time);
    let time = b.time - gap / gain;
    let (falling, rising) = (
        a.velocity_under(acceleration, time),
        b.velocity_under(acceleration, time),
    );
    if !time.is_finite() || falling >= 0.0 || rising <= 0.0 {
        return None;
    }
    // heights by c, by u and by g
    let [xa, xb] = [time - a.time, time - b.time];
    let ([height_a, _], [height_b, _]) = (a.by_gravity(time), b.by_gravity(time));
    // dt = −d(gap)/gain
    let of_time = [1.0, xa, -1.0, -xb, height_a - height_b].map(|slope| slope / gain);
    let of_velocity = |flight: &Parabola, own: usize| {
        let mut slopes: Slopes = of_time.map(|slope| acceleration * slope);
        slopes[own] += 1.0;
        slopes[4] += flight.by_gravity(time)[1];
        slopes
    };
    let (v, v_r) = (of_velocity(a, 1), of_velocity(b, 3));
    let mut of_height: Slopes = of_time.map(|slope| falling * slope);
    for (slope, own) in of_height.iter_mut().zip([1.0, xa, 0.0, 0.0, height_a]) {
        *slope += own;
    }
    let ([ca, ua], [cb, ub]) = (variances(a, sigma), variances(b, sigma));
    let of = [ca, ua, cb, ub, gravity.se * gravity.se];
    let (variance, variance_r) = (covariance(&v, &v, &of), covariance(&v_r, &v_r, &of));
    // v is −ẏ
    let correlation = -covariance(&v, &v_r, &of) / (variance * variance_r).sqrt();
    Some(ContactSpeeds {
        time,
        height: a.height_under(acceleration, time),
        height_sd: covariance(&of_height, &of_height, &of).sqrt(),
        impact_speed: -falling,
        impact_speed_sd: variance.sqrt(),
        rebound_speed: rising,
        rebound_speed_sd: variance_r.sqrt(),
        correlation: usable(correlation),
    })
}

/// The speed at which a flight, of which positions scatter by σ, comes down to a height; `None` where it does not.
pub(super) fn stayed(a: &Parabola, level: Level, sigma: f64, gravity: Gravity) -> Option<ContactSpeeds> {
    let (g, acceleration) = (gravity.value, -gravity.value);
    // from its middle: v² = ẏ² + 2 g (y − level)
    let (velocity, height) = (
        a.velocity_under(acceleration, a.time),
        a.height_under(acceleration, a.time),
    );
    let square = velocity * velocity + 2.0 * g * (height - level.height);
    if square.is_nan() || square <= 0.0 {
        return None;
    }
    let v = square.sqrt();
    let [height_by_g, velocity_by_g] = a.by_gravity(a.time);
    let of_g = (velocity * velocity_by_g + g * height_by_g + (height - level.height)) / v;
    let slopes = [g / v, velocity / v, -g / v, 0.0, of_g];
    let [c, u] = variances(a, sigma);
    let of = [c, u, level.sd * level.sd, 0.0, gravity.se * gravity.se];
    Some(ContactSpeeds {
        time: a.time + (velocity + v) / g,
        height: level.height,
        height_sd: level.sd,
        impact_speed: v,
        impact_speed_sd: covariance(&slopes, &slopes, &of).sqrt(),
        rebound_speed: 0.0,
        rebound_speed_sd: 0.0,
        correlation: 0.0,
    })
}
