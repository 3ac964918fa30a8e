//! Makes the heights of spheres that fall and rebound, whose flights are known: the truth of recordings.

#![allow(dead_code, reason = "shared by several test files")]

/// m/s².
pub const GRAVITY: f64 = 9.81;

/// A sphere that comes down at a speed, and rebounds again and again with one restitution.
#[derive(Debug, Clone, Copy)]
pub struct Bounces {
    /// when it first meets the plate, in s
    pub contact: f64,
    /// v, in m/s
    pub impact_speed: f64,
    /// e
    pub restitution: f64,
}

impl Bounces {
    /// Height over the plate in m. Before it is let go it hangs at the height from which it falls.
    pub fn height(&self, time: f64) -> f64 {
        let before = (self.contact - time).min(self.impact_speed / GRAVITY);
        if before >= 0.0 {
            return self.impact_speed * before - 0.5 * GRAVITY * before * before;
        }
        let (mut start, mut speed) = (self.contact, self.restitution * self.impact_speed);
        // below this a bounce is lower than any camera sees
        while speed > 1e-6 && time >= start + 2.0 * speed / GRAVITY {
            start += 2.0 * speed / GRAVITY;
            speed *= self.restitution;
        }
        let after = time - start;
        (speed * after - 0.5 * GRAVITY * after * after).max(0.0)
    }

    /// When it meets the plate for the second time.
    pub fn second_contact(&self) -> f64 {
        self.contact + 2.0 * self.restitution * self.impact_speed / GRAVITY
    }
}
