//! How far a shaft goes under accelerations: the double integral over time, with viscous friction.

/// Response of a shaft at rest, a time after a push began.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Angle from a unit of speed at the start, s.
    pub to_speed: f64,
    /// Angle from a unit of constant acceleration, s^2.
    pub to_push: f64,
    /// What is left of a unit of speed.
    pub decay: f64,
}

impl Response {
    /// After `time_s` with viscous friction over inertia `viscous`, 1/s.
    #[must_use]
    pub fn after(time_s: f64, viscous: f64) -> Self {
        let damped = viscous * time_s;
        if damped.abs() < 1e-3 {
            // The closed form loses digits here; what the series drops is below 1e-13 of the whole.
            let speed = 1.0 - damped / 2.0 * (1.0 - damped / 3.0 * (1.0 - damped / 4.0));
            let push = 1.0 - damped / 3.0 * (1.0 - damped / 4.0 * (1.0 - damped / 5.0));
            return Self {
                to_speed: time_s * speed,
                to_push: time_s * time_s / 2.0 * push,
                decay: 1.0 - viscous * time_s * speed,
            };
        }
        let to_speed = -libm::expm1(-damped) / viscous;
        Self {
            to_speed,
            to_push: (time_s - to_speed) / viscous,
            decay: 1.0 - viscous * to_speed,
        }
    }
}

/// Shafts that start at rest, each under a push of its own.
#[derive(Clone, Copy, Debug)]
pub struct Motion<const CHANNELS: usize> {
    viscous: f64,
    angle: [f64; CHANNELS],
    speed: [f64; CHANNELS],
}

impl<const CHANNELS: usize> Motion<CHANNELS> {
    /// At rest at angle 0; `viscous` is friction over inertia, 1/s.
    #[must_use]
    pub fn new(viscous: f64) -> Self {
        Self {
            viscous,
            angle: [0.0; CHANNELS],
            speed: [0.0; CHANNELS],
        }
    }

    /// Goes on for `time_s` under constant accelerations.
    pub fn advance(&mut self, time_s: f64, push: &[f64; CHANNELS]) {
        if time_s <= 0.0 {
            return;
        }
        let response = Response::after(time_s, self.viscous);
        for ((angle, speed), push) in self.angle.iter_mut().zip(&mut self.speed).zip(push) {
            *angle += *speed * response.to_speed + push * response.to_push;
            *speed = *speed * response.decay + push * response.to_speed;
        }
    }

    /// Angles gone so far.
    #[must_use]
    pub fn angle(&self) -> [f64; CHANNELS] {
        self.angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_steps_make_the_motion_of_one() {
        for viscous in [0.0, 1e-2, 3.0, 200.0] {
            let whole = Response::after(2.0, viscous);
            let mut motion = Motion::<1>::new(viscous);
            for step in 0..1000 {
                // Steps on both sides of the switch to the series.
                motion.advance(if step % 2 == 0 { 0.0039 } else { 0.0001 }, &[1.0]);
            }
            let [angle] = motion.angle();
            assert!((angle / whole.to_push - 1.0).abs() < 1e-11, "{viscous}");
        }
    }

    #[test]
    fn without_friction_it_is_half_the_square_of_time() {
        let response = Response::after(3.0, 0.0);
        assert_eq!(
            (response.to_speed, response.to_push, response.decay),
            (3.0, 4.5, 1.0)
        );
    }
}
