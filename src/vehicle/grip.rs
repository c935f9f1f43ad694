//! The wheels of one body as constraints on its velocity: springs, and friction that acts against slip.

use crate::body::Velocity;
use glam::{Mat3, Vec2, Vec3};

/// Sweeps over the wheels of a body. They start from the impulses of the last step, so they need few.
const SWEEPS: usize = 10;

/// A body that wheels push: how it moves at the end of the step, as far as that is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mover {
    pub velocity: Velocity,
    /// Zero if it cannot be pushed.
    pub inverse_mass: f32,
    pub inverse_inertia: Mat3,
}

impl Mover {
    /// A body that cannot be pushed.
    pub fn held(velocity: Velocity) -> Self {
        Self {
            velocity,
            inverse_mass: 0.0,
            inverse_inertia: Mat3::ZERO,
        }
    }

    /// The change of velocity at `arm` along an axis by a unit impulse there, 1/kg.
    pub fn yields(&self, arm: Vec3, axis: Vec3) -> f32 {
        let turn = arm.cross(axis);
        self.inverse_mass + turn.dot(self.inverse_inertia * turn)
    }

    pub fn push(&mut self, impulse: Vec3, arm: Vec3) {
        self.velocity.linear += self.inverse_mass * impulse;
        self.velocity.angular += self.inverse_inertia * arm.cross(impulse);
    }
}

/// The spin of a wheel in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spin {
    /// With the engine's torque, without brake and friction, rad/s.
    pub speed: f32,
    /// kg·m².
    pub inertia: f32,
    /// m.
    pub radius: f32,
    /// The angular impulse of brake and rolling resistance at most, N·m·s.
    pub brake: f32,
}

impl Spin {
    /// The impulse along the wheel, N·s, with which its tread does not slip. `free` is the velocity of the ground's point of the body
    /// without it, m/s, and `inverse` the change of that by a unit impulse.
    fn without_slip(&self, free: f32, inverse: f32) -> f32 {
        let locked = -free / inverse;
        let moment = self.inertia * self.speed - self.radius * locked;
        if moment.abs() <= self.brake {
            return locked;
        }
        let speed = self.speed - self.brake.copysign(moment) / self.inertia;
        let inverse = inverse + self.radius * self.radius / self.inertia;
        -(free - self.radius * speed) / inverse
    }

    /// The spin at the end of the step, rad/s, if friction pushes the body by an impulse along the wheel, N·s.
    pub fn after(&self, impulse: f32) -> f32 {
        let moment = self.inertia * self.speed - self.radius * impulse;
        (moment.abs() - self.brake).max(0.0).copysign(moment) / self.inertia
    }
}

/// The suspension in a step, for speeds of separation along the normal of the ground at the end of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spring {
    /// Its impulse at speed zero, N·s.
    pub push: f32,
    /// Its change with the speed, kg.
    pub gain: f32,
    /// The least speed, m/s: less would compress the suspension by more than its travel.
    pub least_speed: f32,
}

/// A wheel that touches the ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    /// Where it touches, from the centres of mass of vehicle and ground, world axes, m.
    pub arms: [Vec3; 2],
    /// Normal of the ground, forwards, and to the right: orthogonal unit vectors.
    pub axes: [Vec3; 3],
    /// The ground. Wheels on the same body do not know of each other's pushes in this step.
    pub ground: Mover,
    pub spring: Spring,
    /// Coefficients of friction along and across.
    pub friction: Vec2,
    /// Speed of slip that takes the tread back to where it belongs, m/s.
    pub bias: Vec2,
    pub spin: Spin,
    /// Impulses on the vehicle along the axes, N·s.
    pub impulses: Vec3,
    /// Whether friction did not suffice.
    pub slides: bool,
}

impl Touch {
    /// The impulse on the vehicle, N·s.
    pub fn impulse(&self) -> Vec3 {
        let [normal, along, across] = self.axes;
        self.impulses.x * normal + self.impulses.y * along + self.impulses.z * across
    }

    /// The velocity of the vehicle's point against the ground's, along the axes, m/s.
    pub fn speeds(&self, vehicle: &Mover) -> Vec3 {
        let [arm, ground_arm] = self.arms;
        let velocity = vehicle.velocity.at(arm) - self.ground.velocity.at(ground_arm);
        Vec3::from_array(self.axes.map(|axis| axis.dot(velocity)))
    }

    fn yields(&self, vehicle: &Mover, axis: usize) -> f32 {
        let ([arm, ground_arm], axis) = (self.arms, self.axes[axis]);
        vehicle.yields(arm, axis) + self.ground.yields(ground_arm, axis)
    }

    fn add(&mut self, vehicle: &mut Mover, impulse: Vec3) {
        let [arm, ground_arm] = self.arms;
        vehicle.push(impulse, arm);
        self.ground.push(-impulse, ground_arm);
    }

    fn relax(&mut self, vehicle: &mut Mover) {
        let before = self.impulse();
        let yields = self.yields(vehicle, 0);
        let free = self.speeds(vehicle).x - yields * self.impulses.x;
        let Spring {
            push,
            gain,
            least_speed,
        } = self.spring;
        let springs = (push - gain * free) / (1.0 + gain * yields);
        let stops = (least_speed - free) / yields;
        self.impulses.x = springs.max(stops).max(0.0);
        self.add(vehicle, self.impulse() - before);

        let before = self.impulse();
        let yields = Vec2::new(self.yields(vehicle, 1), self.yields(vehicle, 2));
        let grip = Vec2::new(self.impulses.y, self.impulses.z);
        let speeds = self.speeds(vehicle);
        let free = Vec2::new(speeds.y, speeds.z) - yields * grip + self.bias;
        let wanted = Vec2::new(self.spin.without_slip(free.x, yields.x), -free.y / yields.y);
        let most = self.impulses.x * self.friction;
        let share = (wanted / most.max(Vec2::splat(f32::MIN_POSITIVE))).length();
        self.slides = share > 1.0;
        let grip = match self.slides {
            true => wanted / share,
            false => wanted,
        };
        (self.impulses.y, self.impulses.z) = (grip.x, grip.y);
        self.add(vehicle, self.impulse() - before);
    }
}

/// Computes the impulses of the wheels of a vehicle, which change its velocity.
pub(super) fn solve(vehicle: &mut Mover, wheels: &mut [Touch]) {
    for wheel in &mut *wheels {
        wheel.add(vehicle, wheel.impulse());
    }
    for sweep in 0..SWEEPS {
        // To and fro, so that no side is preferred.
        match sweep % 2 {
            0 => wheels.iter_mut().for_each(|wheel| wheel.relax(vehicle)),
            _ => wheels
                .iter_mut()
                .rev()
                .for_each(|wheel| wheel.relax(vehicle)),
        }
    }
}
