//! Bodies of all kinds and sizes, and pairs of them whose features coincide or nearly do.

use super::truth::{Form, Pose};
use drystone::collider::Polyhedron;
use drystone::narrowphase::polyhedra::{
    Axis, Contact, Cuboid, Placement, Search, Solid, Triangle, meet,
};
use fastrand::Rng;
use glam::{DQuat, DVec3, Quat, Vec3};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// The input of the code under test.
pub enum Body {
    Cuboid(Vec3),
    Hull(Box<Polyhedron>),
    Triangle([Vec3; 3]),
}

/// A body and its corners.
pub struct Shape {
    pub name: &'static str,
    pub body: Body,
    pub form: Form,
}

impl Shape {
    pub fn cuboid(name: &'static str, half: Vec3) -> Self {
        Self {
            name,
            form: Form::of(&Cuboid::new(half)),
            body: Body::Cuboid(half),
        }
    }

    /// `None` if the points enclose no volume.
    pub fn hull(name: &'static str, points: &[Vec3]) -> Option<Self> {
        let hull = Polyhedron::new(points).ok()?;
        Some(Self {
            name,
            form: Form::of(&hull),
            body: Body::Hull(hull.into()),
        })
    }

    pub fn triangle(points: [Vec3; 3]) -> Option<Self> {
        Some(Self {
            name: "triangle",
            form: Form::of(&Triangle::new(points)?),
            body: Body::Triangle(points),
        })
    }

    /// As a mirror at x = 0 shows it.
    pub fn mirrored(&self) -> Self {
        let mirror = |p: &Vec3| Vec3::new(-p.x, p.y, p.z);
        let mirrored = match &self.body {
            Body::Cuboid(half) => Some(Self::cuboid(self.name, *half)),
            Body::Hull(hull) => {
                let points: Vec<_> = hull.points.iter().map(mirror).collect();
                Self::hull(self.name, &points)
            }
            Body::Triangle(points) => Self::triangle(points.map(|p| mirror(&p))),
        };
        mirrored.expect("it was none the less a body before")
    }

    /// A cuboid as a hull.
    pub fn as_hull(&self) -> Option<Self> {
        match self.body {
            Body::Cuboid(half) => Self::hull("cuboid as hull", &corners(half)),
            _ => None,
        }
    }
}

pub fn corners(half: Vec3) -> Vec<Vec3> {
    let sign = |i: i32, bit: i32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let corner = |i| half * Vec3::new(sign(i, 0), sign(i, 1), sign(i, 2));
    (0..8).map(corner).collect()
}

/// Computes the contact. `axis` is the axis of the last step, and then that of this step.
pub fn contact(a: &Body, b: &Body, poses: [Pose; 2], search: Search, axis: &mut Axis) -> Contact {
    let place = &Placement::between(poses[0], poses[1]);
    let mut contact = Contact::default();
    let out = &mut contact;
    match a {
        Body::Cuboid(half) => with(&Cuboid::new(*half), b, place, search, axis, out),
        Body::Hull(hull) => with(&**hull, b, place, search, axis, out),
        Body::Triangle(points) => {
            let triangle = Triangle::new(*points).expect("it was one before");
            with(&triangle, b, place, search, axis, out);
        }
    }
    contact
}

fn with(
    a: &impl Solid,
    b: &Body,
    place: &Placement,
    search: Search,
    axis: &mut Axis,
    contact: &mut Contact,
) {
    match b {
        Body::Cuboid(half) => meet(a, &Cuboid::new(*half), place, search, axis, contact),
        Body::Hull(hull) => meet(a, &**hull, place, search, axis, contact),
        Body::Triangle(points) => {
            let triangle = Triangle::new(*points).expect("it was one before");
            meet(a, &triangle, place, search, axis, contact)
        }
    };
}

/// Part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    Face,
    Edge,
    Corner,
}

/// Two bodies and how they stand.
pub struct Pair<'a> {
    pub shapes: [&'a Shape; 2],
    pub poses: [Pose; 2],
    pub kind: [Feature; 2],
}

/// Random choices.
pub struct Dice(pub Rng);

impl Dice {
    fn share(&mut self) -> f64 {
        self.0.f64()
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// As many of each order of magnitude.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        (self.between(low.ln(), high.ln())).exp()
    }

    pub fn sign(&mut self) -> f64 {
        if self.0.bool() { 1.0 } else { -1.0 }
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let at = DVec3::from_array(std::array::from_fn(|_| self.between(-1.0, 1.0)));
            if (1e-2..1.0).contains(&at.length()) {
                return at.normalize();
            }
        }
    }

    fn rotation(&mut self) -> DQuat {
        let angle = self.between(0.0, TAU);
        DQuat::from_axis_angle(self.direction(), angle)
    }

    fn of<'t, T>(&mut self, all: &'t [T]) -> &'t T {
        &all[self.0.usize(..all.len())]
    }

    /// Next to nothing or nothing, in rad or shares of the size.
    fn little(&mut self, most: f64) -> f64 {
        match self.0.bool() {
            true => 0.0,
            false => self.sign() * self.log(1e-7, most),
        }
    }

    fn point(&mut self, half: DVec3) -> DVec3 {
        half * DVec3::from_array(std::array::from_fn(|_| self.between(-1.0, 1.0)))
    }

    /// A prism, or what a prism is when one end is smaller: a voussoir, a wedge's frustum.
    fn prism(&mut self, size: f64) -> Vec<DVec3> {
        let sides = self.0.usize(3..=16);
        let length = self.between(0.2, 1.5) * size;
        let (narrow, turn) = (*self.of(&[1.0, 1.0, 0.95, 0.5]), self.share());
        let around = |i: usize| TAU * (i as f64 + turn) / sides as f64;
        let corner = |i: usize, z: f64, r: f64| {
            DVec3::new(0.5 * r * around(i).cos(), 0.5 * r * around(i).sin(), z)
        };
        (0..sides)
            .flat_map(|i| {
                [
                    corner(i, -0.5 * length, size),
                    corner(i, 0.5 * length, narrow * size),
                ]
            })
            .collect()
    }

    fn shape(&mut self, size: f64) -> Option<Shape> {
        let half = 0.5 * size * DVec3::from_array(std::array::from_fn(|_| self.between(0.3, 1.0)));
        let [thin, wide] = [0.005 * size, 0.5 * size];
        let turn = self.rotation();
        let single = |points: Vec<DVec3>| points.iter().map(|p| p.as_vec3()).collect::<Vec<_>>();
        match self.0.u32(..12) {
            0 | 1 => Some(Shape::cuboid("cuboid", half.as_vec3())),
            2 => Some(Shape::cuboid("cube", Vec3::splat(0.5 * size as f32))),
            3 => Some(Shape::cuboid(
                "slab",
                DVec3::new(wide, thin, wide).as_vec3(),
            )),
            4 => Some(Shape::cuboid("rod", DVec3::new(thin, thin, wide).as_vec3())),
            5 | 6 => {
                let points = self.prism(size);
                Shape::hull("prism", &single(points))
            }
            7 => {
                // Off its axes, as imported meshes are.
                let points = self.prism(size).into_iter().map(|p| turn * p).collect();
                Shape::hull("turned prism", &single(points))
            }
            8 => {
                let count = self.0.usize(4..=64);
                let points = (0..count).map(|_| 2.0 * half * self.direction() * 0.5);
                Shape::hull("round hull", &single(points.collect()))
            }
            9 => {
                let count = self.0.usize(4..=24);
                let points = (0..count).map(|_| self.point(half));
                Shape::hull("hull", &single(points.collect()))
            }
            10 => {
                let half = *self.of(&[
                    half,
                    DVec3::new(wide, thin, wide),
                    DVec3::new(thin, thin, wide),
                ]);
                let points = corners(half.as_vec3());
                let points = points.iter().map(|p| turn * p.as_dvec3()).collect();
                Shape::hull("turned box", &single(points))
            }
            _ => {
                let corners = std::array::from_fn(|_| self.point(DVec3::splat(wide)).as_vec3());
                let [a, b, c] = corners;
                // Needles are for another test.
                let wide = (b - a).cross(c - a).length() as f64;
                (wide > 0.05 * size * size).then(|| Shape::triangle(corners))?
            }
        }
    }

    /// Bodies of about one size.
    pub fn shapes(&mut self, count: usize) -> Vec<Shape> {
        let size = self.log(1e-3, 100.0);
        let mut shapes = Vec::new();
        while shapes.len() < count {
            let size = size * self.between(0.3, 1.0);
            shapes.extend(self.shape(size));
        }
        shapes
    }

    /// A place on a body: a point, a direction away from the body, and one across.
    fn place(&mut self, form: &Form, feature: Feature) -> (DVec3, DVec3, DVec3) {
        let point = |i: u16| form.points[i as usize];
        match feature {
            Feature::Face => {
                let whole: Vec<_> = (0..form.faces.len())
                    .filter(|&f| form.faces[f].len() > 2)
                    .collect();
                let face = *self.of(&whole);
                let corners = &form.faces[face];
                let from = self.0.usize(..corners.len());
                let (p, q) = (
                    point(corners[from]),
                    point(corners[(from + 1) % corners.len()]),
                );
                let middle = form.corners(face).sum::<DVec3>() / corners.len() as f64;
                let at = match self.0.u32(..5) {
                    0 => p,
                    1 => p.lerp(q, 0.5),
                    2 => p.lerp(q, self.share()),
                    3 => middle,
                    _ => middle.lerp(p.lerp(q, self.share()), self.share()),
                };
                (at, form.normal(face), q - p)
            }
            Feature::Edge => {
                let edge = self.0.usize(..form.edges.len());
                let [p, q] = form.edges[edge].map(point);
                let [x, y] = form.beside[edge].map(|f| form.normal(f as usize));
                let share = *self.of(&[0.0, 0.5, 0.0001, 0.01, 0.3, 0.7]);
                let at = match self.0.u32(..3) {
                    0 => p,
                    1 => p.lerp(q, 0.5),
                    _ => p.lerp(q, self.share()),
                };
                (at, x.lerp(y, share).normalize_or(x), q - p)
            }
            Feature::Corner => {
                let i = self.0.usize(..form.points.len()) as u16;
                let around = (0..form.faces.len()).filter(|&f| form.faces[f].contains(&i));
                let out: DVec3 = around.map(|f| self.share() * form.normal(f)).sum();
                let edge = form.edges.iter().find(|ends| ends.contains(&i));
                let [p, q] = edge.expect("a corner has edges").map(point);
                (point(i), out.normalize_or(DVec3::Y), q - p)
            }
        }
    }

    fn feature(&mut self) -> Feature {
        *self.of(&[Feature::Face, Feature::Face, Feature::Edge, Feature::Corner])
    }

    /// A pair that touches, nearly.
    pub fn pair<'a>(&mut self, shapes: &'a [Shape]) -> Pair<'a> {
        let pair = loop {
            let pair = [self.of(shapes), self.of(shapes)];
            if pair.iter().any(|s| !matches!(s.body, Body::Triangle(_))) {
                break pair;
            }
        };
        let kind = [self.feature(), self.feature()];
        let size = pair[0].form.size.min(pair[1].form.size);
        let (p, n, t) = self.place(&pair[0].form, kind[0]);
        let (q, m, s) = self.place(&pair[1].form, kind[1]);
        let frame = |n: DVec3, t: DVec3| {
            let t = t.reject_from(n).try_normalize();
            let t = t.unwrap_or(n.any_orthonormal_vector());
            DQuat::from_mat3(&glam::DMat3::from_cols(t, n, t.cross(n)))
        };
        let yaw = match self.0.u32(..7) {
            0 | 1 => 0.0,
            2 => PI,
            3 => FRAC_PI_4,
            4 => 1f64.to_radians(),
            5 => self.log(1e-7, 0.1),
            _ => self.between(0.0, TAU),
        };
        let tilt = self.little(0.2);
        let tilt = DQuat::from_axis_angle(self.direction(), tilt);
        // Onto A: out of B is into A.
        let turn = tilt * DQuat::from_axis_angle(n, yaw) * frame(n, t) * frame(-m, s).inverse();
        let gap = self.sign() * self.log(1e-7, 1e-2) * size;
        let aside = match self.0.u32(..4) {
            0 | 1 => 0.0,
            2 => self.log(1e-7, 1e-2),
            _ => self.log(1e-2, 0.5),
        };
        let aside = aside * size * self.direction().reject_from(n);
        let origin = p + gap * n + aside - turn * q;
        // Somewhere in the world.
        let world = match self.0.bool() {
            true => self.rotation(),
            false => DQuat::IDENTITY,
        };
        let far = self.of(&[0.0, 1.0, 30.0]) * size * self.direction();
        let pose = |at: DVec3, turn: DQuat| -> Pose { (at.as_vec3(), single(turn)) };
        Pair {
            shapes: pair,
            poses: [pose(far, world), pose(far + world * origin, world * turn)],
            kind,
        }
    }

    /// Moved by next to nothing.
    pub fn jitter(&mut self, pose: Pose, size: f64, share: f64) -> Pose {
        let turn = DQuat::from_axis_angle(self.direction(), share) * pose.1.as_dquat();
        let at = pose.0.as_dvec3() + share * size * self.direction();
        (at.as_vec3(), single(turn))
    }
}

fn single(turn: DQuat) -> Quat {
    turn.normalize().as_quat()
}
