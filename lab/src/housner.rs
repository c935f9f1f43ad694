//! A slender block that rocks on a rigid floor, after Housner (1963), "The behavior of inverted pendulum structures during earthquakes", in
//! double precision. It shares no code with the engine.

/// The step of the integration, s.
const STEP: f64 = 1e-4;

/// A block of width 2b and height 2h that turns about one lower edge or the other, and does not slide.
#[derive(Clone, Copy, Debug)]
pub struct Block {
    /// tan α = b / h: it falls when it leans by more than α, rad.
    pub alpha: f64,
    /// p² = 3 g / 4R, 1/s², where R is the distance of an edge from the centre.
    pub p2: f64,
    gravity: f64,
}

/// How far a block leans, rad, and how fast, rad/s. Positive about the left edge.
#[derive(Clone, Copy, Debug)]
pub struct Lean {
    /// rad
    pub angle: f64,
    /// rad/s
    pub speed: f64,
}

impl Block {
    /// A block of this width and height, m.
    pub fn new(width: f64, height: f64, gravity: f64) -> Self {
        let (b, h) = (0.5 * width, 0.5 * height);
        Self {
            alpha: (b / h).atan(),
            p2: 0.75 * gravity / b.hypot(h),
            gravity,
        }
    }

    /// ω⁺/ω⁻ of an impact: angular momentum about the edge that hits is kept.
    pub fn kept(&self) -> f64 {
        1.0 - 1.5 * self.alpha.sin() * self.alpha.sin()
    }

    /// Energy of a lean at rest over that of standing on an edge, as a share of the weight times R.
    pub fn energy(&self, angle: f64) -> f64 {
        (self.alpha - angle.abs()).cos() - self.alpha.cos()
    }

    /// The lean with such an energy, rad.
    pub fn angle_of(&self, energy: f64) -> f64 {
        self.alpha - (energy + self.alpha.cos()).min(1.0).acos()
    }

    /// The angular acceleration, rad/s², on a floor that accelerates by `floor`, m/s², against the positive lean.
    fn acceleration(&self, angle: f64, side: f64, floor: f64) -> f64 {
        let from = self.alpha - side * angle;
        self.p2 * (-side * from.sin() + floor / self.gravity * from.cos())
    }

    /// Integrates a lean until `until` s. `floor` gives the acceleration of the floor at a time, m/s²; the block leans against it. `tell`
    /// gets each time and lean, and says whether to go on.
    pub fn rock(
        &self,
        mut lean: Lean,
        until: f64,
        floor: impl Fn(f64) -> f64,
        mut tell: impl FnMut(f64, Lean) -> bool,
    ) -> Lean {
        let mut side = if lean.angle == 0.0 {
            0.0
        } else {
            lean.angle.signum()
        };
        let steps = (until / STEP).round() as usize;
        for i in 0..steps {
            let t = i as f64 * STEP;
            if side == 0.0 {
                // It stands, until the floor tips it.
                let push = floor(t) / self.gravity;
                if push.abs() > self.alpha.tan() {
                    side = push.signum();
                }
            }
            if side != 0.0 {
                let next = self.step(lean, side, t, STEP, &floor);
                lean = match next.angle * side < 0.0 {
                    false => next,
                    true => {
                        let share = lean.angle / (lean.angle - next.angle);
                        let hit = self.step(lean, side, t, share * STEP, &floor);
                        let speed = self.kept() * hit.speed;
                        side = speed.signum();
                        let angle = side * 1e-15;
                        let after = Lean { angle, speed };
                        self.step(after, side, t + share * STEP, (1.0 - share) * STEP, &floor)
                    }
                };
            }
            if !tell(t + STEP, lean) {
                break;
            }
        }
        lean
    }

    /// One step of Runge and Kutta's method.
    fn step(&self, lean: Lean, side: f64, t: f64, h: f64, floor: &impl Fn(f64) -> f64) -> Lean {
        let rate = |angle: f64, t: f64| self.acceleration(angle, side, floor(t));
        let half = 0.5 * h;
        let (v1, a1) = (lean.speed, rate(lean.angle, t));
        let (v2, a2) = (v1 + half * a1, rate(lean.angle + half * v1, t + half));
        let (v3, a3) = (v1 + half * a2, rate(lean.angle + half * v2, t + half));
        let (v4, a4) = (v1 + h * a3, rate(lean.angle + h * v3, t + h));
        Lean {
            angle: lean.angle + h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4),
            speed: v1 + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// The integration beside the closed form.
    #[test]
    fn a_block_keeps_its_energy_until_it_hits() {
        let block = Block::new(0.5, 2.0, 9.81);
        let start = 0.5 * block.alpha;
        let lean = Lean {
            angle: start,
            speed: 0.0,
        };
        let mut most = 0.0f64;
        let rest = |_| 0.0;
        block.rock(lean, 1.5, rest, |_, lean| {
            most = most.max(-lean.angle);
            true
        });
        let expected = block.angle_of(block.kept().powi(2) * block.energy(start));
        assert!((most - expected).abs() < 1e-6 * start, "{most}, {expected}");
    }

    /// Another integration found 0.4504 g.
    #[test]
    fn a_block_falls_at_a_pulse_as_strong_as_in_another_integration() {
        let block = Block::new(0.5, 2.0, 9.81);
        let rate = 2.0 * block.p2.sqrt();
        let falls = |share: f64| {
            let pulse = |t: f64| share * 9.81 * (rate * t).min(PI).sin();
            let lean = Lean {
                angle: 0.0,
                speed: 0.0,
            };
            let end = block.rock(lean, 10.0, pulse, |_, lean| lean.angle.abs() < 1.5);
            end.angle.abs() >= 1.5
        };
        assert!(!falls(0.449) && falls(0.452));
    }
}
