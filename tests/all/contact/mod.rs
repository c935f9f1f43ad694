//! The contact of two convex polyhedra against brute force in double precision, on random pairs whose features coincide or nearly
//! do; and what no pair may do.
//!
//! `cargo test --test all contact:: -- --nocapture` prints the worst errors by kind; `-- --ignored --nocapture` runs millions.

mod pairs;
mod steady;
mod strange;
mod truth;

use drystone::narrowphase::polyhedra::{Axis, Contact, FeatureId, Search};
use fastrand::Rng;
use glam::{DVec3, Quat, Vec3};
use pairs::{Body, Dice, Feature, Pair, Shape, contact};
use std::collections::BTreeMap;
use truth::{DEPTH, Pose, Stood, Truth, apart, is_above, shared};

/// Degrees between a normal and that of the features it is made of.
const ANGLE: f64 = 0.1;

/// The share of a polygon's area.
const AREA: f64 = 0.01;

/// Polygons of a lesser share of the face are slivers: their extent counts.
const SLIVER: f64 = 1e-4;

/// Tolerance beyond the end of an edge, as a share of the size (the code's slack).
const BORDER: f64 = 1.1e-4;

/// A contact in the world.
pub struct Seen {
    pub axis: Axis,
    /// From A to B.
    pub normal: DVec3,
    pub points: Vec<Spot>,
}

#[derive(Clone, Copy)]
pub struct Spot {
    pub at: DVec3,
    pub distance: f64,
    pub feature: FeatureId,
}

impl Seen {
    /// `pose`: that of the body in whose frame the contact is.
    pub fn of(contact: &Contact, axis: Axis, pose: Pose) -> Self {
        let turn = pose.1.as_dquat().normalize();
        let points = contact.points.iter().map(|point| Spot {
            at: turn * point.position + pose.0.as_dvec3(),
            distance: point.distance,
            feature: point.feature,
        });
        Self {
            axis,
            normal: turn * -contact.normal,
            points: points.collect(),
        }
    }

    /// With the bodies exchanged.
    pub fn exchanged(mut self) -> Self {
        self.normal = -self.normal;
        self.axis = match self.axis {
            Axis::Unknown => Axis::Unknown,
            Axis::FaceOfA(i) => Axis::FaceOfB(i),
            Axis::FaceOfB(i) => Axis::FaceOfA(i),
            Axis::Edges(i, j) => Axis::Edges(j, i),
        };
        for point in &mut self.points {
            point.feature = exchanged(point.feature);
        }
        self
    }

    fn mirrored(mut self) -> Self {
        self.normal.x = -self.normal.x;
        self.points.iter_mut().for_each(|p| p.at.x = -p.at.x);
        self
    }

    pub fn deepest(&self) -> Option<f64> {
        self.points.iter().map(|p| p.distance).reduce(f64::min)
    }

    pub fn area(&self) -> f64 {
        let corners: Vec<_> = self.points.iter().map(|p| p.at).collect();
        0.5 * truth::twice_area(&corners).dot(self.normal).abs()
    }

    fn extent(&self) -> f64 {
        let far = |p: &Spot| {
            let flat = |q: &Spot| (q.at - p.at).reject_from(self.normal).length();
            self.points.iter().map(flat).fold(0.0, f64::max)
        };
        self.points.iter().map(far).fold(0.0, f64::max)
    }

    pub fn features(&self) -> Vec<u32> {
        let mut features: Vec<_> = self.points.iter().map(|p| p.feature.0).collect();
        features.sort_unstable();
        features
    }
}

/// The identity of a feature when A and B are exchanged.
fn exchanged(feature: FeatureId) -> FeatureId {
    let number = |shift: u32| ((feature.0 >> shift) & 0x7FFF) as u16;
    match feature.0 >> 30 {
        1 => FeatureId::corner_of_b(number(15)),
        2 => FeatureId::corner_of_a(number(0)),
        _ => FeatureId::edges(number(0), number(15)),
    }
}

/// Errors, as shares of what they are shares of.
#[derive(Clone, Copy, Default)]
struct Errors {
    /// The separation along the normal against the best, of the size.
    axis: f64,
    /// Degrees.
    normal: f64,
    /// The deepest point against the separation, of the size.
    depth: f64,
    /// Points off the surfaces they join, of the size.
    off: f64,
    /// Tolerance of the polygon's area.
    area: f64,
    /// Tolerance of the face's extent.
    extent: f64,
    /// Points on the border may be inside or outside. Here this matters, so the area is between the two.
    is_thin: bool,
}

impl Errors {
    fn worst(&mut self, other: &Self) {
        self.axis = self.axis.max(other.axis);
        self.normal = self.normal.max(other.normal);
        self.depth = self.depth.max(other.depth);
        self.off = self.off.max(other.off);
        self.area = self.area.max(other.area);
        self.extent = self.extent.max(other.extent);
    }

    fn too_large(&self) -> Option<String> {
        let all = [
            ("axis", self.axis, DEPTH),
            ("normal", self.normal, ANGLE),
            ("depth", self.depth, DEPTH),
            ("off", self.off, DEPTH),
            ("area", self.area, AREA),
            ("extent", self.extent, AREA),
        ];
        // NaN counts as too large.
        let large = all
            .iter()
            .find(|(_, error, most)| error.is_nan() || error > most)?;
        Some(format!("{} {:.2e}", large.0, large.1))
    }
}

/// The data of a pair with which a contact is checked.
struct Judge<'a> {
    a: Stood<'a>,
    b: Stood<'a>,
    truth: Truth,
    reach: f64,
}

impl<'a> Judge<'a> {
    fn new(pair: &Pair<'a>, reach: f64) -> Self {
        let [a, b] = [0, 1].map(|i| pair.shapes[i].form.at(pair.poses[i]));
        let truth = Truth::of(&a, &b);
        Self { a, b, truth, reach }
    }

    /// # Errors
    /// Errors of a contact that need no reference.
    fn errors(&self, seen: &Seen) -> Result<Errors, String> {
        let (truth, size) = (&self.truth, self.truth.size);
        let (most, mut errors) = (truth.most(), Errors::default());
        let mut ids = seen.features();
        ids.dedup();
        if ids.len() < seen.points.len() {
            return Err("two points of one name".into());
        }
        if most > self.reach {
            // Any direction that parts them that far will do.
            return match seen.points.is_empty() || most < self.reach + DEPTH * size {
                true => Ok(errors),
                false => Err("a contact beyond reach".into()),
            };
        }
        let right = truth.normal(&self.a, &self.b, seen.axis, seen.normal);
        let right = right.ok_or("no such axis")?;
        errors.axis = truth.missed_by(&self.a, &self.b, seen.axis, seen.normal) / size;
        errors.normal = seen.normal.angle_between(right).to_degrees();
        let Some(deepest) = seen.deepest() else {
            return match most < -1e-6 * size {
                true => Err(format!(
                    "no contact where they overlap by {:.1e} of the size",
                    -most / size
                )),
                false => Ok(errors),
            };
        };
        if seen.points.iter().any(|p| p.distance > self.reach) {
            return Err("a point beyond reach".into());
        }
        let along = apart(&self.a, &self.b, seen.normal);
        errors.depth = (along - deepest).max(0.0) / size;
        match seen.axis {
            Axis::Edges(i, j) => {
                errors.depth = (deepest - along).abs() / size;
                // If edges are almost parallel, the adjacent faces give the contact.
                if seen.points[0].feature == FeatureId::edges(i, j) {
                    errors.off = self.off_edges(i, j, seen)? / size;
                }
            }
            Axis::FaceOfA(i) => self.on_face((&self.a, i), &self.b, 1.0, seen, &mut errors),
            Axis::FaceOfB(i) => self.on_face((&self.b, i), &self.a, -1.0, seen, &mut errors),
            Axis::Unknown => {}
        }
        Ok(errors)
    }

    /// How far a point is from the edges it joins, m.
    fn off_edges(&self, i: u16, j: u16, seen: &Seen) -> Result<f64, String> {
        let [point] = seen.points[..] else {
            return Err("more than one point of two edges".into());
        };
        let half = 0.5 * point.distance * seen.normal;
        let off = |[p, q]: [DVec3; 2], at: DVec3| {
            let way = (q - p).normalize();
            let along = (at - p).dot(way);
            let past = (-along).max(along - p.distance(q));
            match past > BORDER * self.truth.size {
                true => f64::INFINITY,
                false => (at - p).reject_from(way).length(),
            }
        };
        Ok(off(self.a.ends(i), point.at - half).max(off(self.b.ends(j), point.at + half)))
    }

    /// `way`: whether the face looks as the normal does.
    fn on_face(
        &self,
        (reference, face): (&Stood, u16),
        incident: &Stood,
        way: f64,
        seen: &Seen,
        errors: &mut Errors,
    ) {
        let size = self.truth.size;
        let normal = way * seen.normal;
        let corners = reference.corners(face);
        // If the deepest corner is above the face, its depth is that of the contact.
        let along = apart(&self.a, &self.b, seen.normal);
        let low = -incident.reach(-normal);
        let mut lowest = incident
            .points
            .iter()
            .filter(|p| p.dot(normal) <= low + 1e-9 * size);
        let deepest = seen.deepest().unwrap_or(f64::INFINITY);
        if lowest.any(|p| is_above(&corners, normal, *p)) {
            errors.depth = (deepest - along).abs() / size;
        }
        let of_incident = |below: u16| {
            let mut errors = *errors;
            let out = incident.normals[below as usize];
            let below = incident.corners(below);
            let off = |point: &Spot| {
                let half = 0.5 * point.distance * normal;
                let [up, down] = [point.at + half, point.at - half];
                let of_reference = (down - corners[0]).dot(reference.normals[face as usize]);
                of_reference.abs().max((up - below[0]).dot(out).abs())
            };
            errors.off = seen.points.iter().map(off).fold(0.0, f64::max) / size;
            if self.reach > size && corners.len() > 2 && below.len() > 2 {
                let shared_by = |border: f64| shared(&corners, &below, normal, border * size);
                let shared = shared_by(0.0);
                let flat = |corners: &[DVec3]| 0.5 * truth::twice_area(corners).dot(normal).abs();
                let face = flat(&corners).min(flat(&below));
                let [least, most] = [-BORDER, BORDER].map(shared_by);
                if shared.area >= SLIVER * face {
                    errors.is_thin = most.area - least.area > AREA * shared.area;
                    errors.area = match errors.is_thin {
                        true => (least.area - seen.area())
                            .max(seen.area() - most.area)
                            .max(0.0),
                        false => (seen.area() - shared.area).abs(),
                    } / shared.area;
                } else {
                    let wide = |corners: &[DVec3]| {
                        let far =
                            |p: &DVec3| corners.iter().map(|q| p.distance(*q)).fold(0.0, f64::max);
                        corners.iter().map(far).fold(0.0, f64::max)
                    };
                    let wide = wide(&corners).min(wide(&below));
                    let extent = seen.extent();
                    let off = (least.extent - extent).max(extent - most.extent);
                    errors.extent = off.max(0.0) / wide;
                }
            }
            errors
        };
        let candidates = incident.facing(-normal).into_iter().map(of_incident);
        let badness = |e: &Errors| (e.off / DEPTH).max(e.area / AREA).max(e.extent / AREA);
        if let Some(best) = candidates.min_by(|x, y| badness(x).total_cmp(&badness(y))) {
            *errors = best;
        }
    }

    fn has_parallel_faces(&self, normal: DVec3) -> bool {
        let looks = |of: &Stood, way: DVec3| of.normals.iter().any(|n| n.distance(way) < 1e-5);
        looks(&self.a, normal) && looks(&self.b, -normal)
    }

    /// Two faces of the one on top look down as much: at an angle of 45°, say.
    fn can_stand_on_either(&self, seen: &Seen) -> bool {
        let faces = match seen.axis {
            Axis::FaceOfA(_) => self.b.facing(-seen.normal),
            Axis::FaceOfB(_) => self.a.facing(seen.normal),
            _ => return false,
        };
        faces.iter().any(|face| *face != faces[0])
    }

    /// Two views of one pair must be the same, unless directions are equally good; then each has been judged by itself.
    fn same(&self, one: &Seen, two: &Seen) -> Result<bool, String> {
        if self.truth.most() > self.reach - DEPTH * self.truth.size {
            return Ok(true);
        }
        if one.normal.angle_between(two.normal).to_degrees() > 2.0 * ANGLE {
            return Ok(false);
        }
        if self.can_stand_on_either(one) {
            return Ok(false);
        }
        let size = self.truth.size;
        let (Some(x), Some(y)) = (one.deepest(), two.deepest()) else {
            // The solids are almost apart and almost beside each other: they overlap by the border of one, but not by that of the other.
            return match one.points.is_empty() == two.points.is_empty() {
                true => Ok(true),
                false if self.truth.most() > -1e-6 * size => Ok(false),
                false => Err("one has points and one has none".into()),
            };
        };
        let by = |seen: &Seen| std::mem::discriminant(&seen.axis);
        let is_other = by(one) != by(two);
        if is_other && !self.has_parallel_faces(one.normal) {
            // The other solid is the reference, and its faces give other distances if the faces are not parallel.
            return Ok(false);
        }
        if (x - y).abs() > 2.0 * DEPTH * size {
            if self.truth.most() > 0.0 {
                // Apart: of directions as good, each has other corners above its face.
                return Ok(false);
            }
            return Err(format!(
                "depths of {:.3e} and {:.3e} of the size",
                x / size,
                y / size
            ));
        }
        if !is_other && self.reach > size && one.points.len() > 2 && two.points.len() > 2 {
            let (x, y) = (one.area(), two.area());
            if (x - y).abs() > AREA * x.max(y) && (x - y).abs() > SLIVER * size * size {
                return Err(format!("areas of {x:.3e} and {y:.3e} m²"));
            }
        }
        Ok(true)
    }
}

/// One in this many pairs may differ: if edges are parallel up to single precision, it is undetermined which of them cross.
const MISSED: usize = 50_000;

/// The results for a kind of pair.
#[derive(Default)]
struct Row {
    pairs: usize,
    touching: usize,
    ties: usize,
    thin: usize,
    errors: Errors,
}

/// Everything found.
#[derive(Default)]
pub struct Table {
    rows: BTreeMap<String, Row>,
    failures: Vec<String>,
    failed: usize,
}

impl Table {
    fn fails(&mut self, what: String) {
        self.failed += 1;
        if self.failures.len() < 40 {
            self.failures.push(what);
        }
    }

    fn add(&mut self, other: Self) {
        for (kind, row) in other.rows {
            let own = self.rows.entry(kind).or_default();
            own.pairs += row.pairs;
            own.touching += row.touching;
            own.ties += row.ties;
            own.thin += row.thin;
            own.errors.worst(&row.errors);
        }
        self.failed += other.failed;
        self.failures.extend(other.failures);
    }

    #[track_caller]
    fn holds(&self) {
        println!(
            "| {:<15} | {:>8} | {:>8} | {:>6} | {:>6} | axis    | normal° | depth   | off     | area    | extent  |",
            "kind", "pairs", "touching", "ties", "thin"
        );
        for (kind, row) in &self.rows {
            let e = &row.errors;
            println!(
                "| {kind:<15} | {:>8} | {:>8} | {:>6} | {:>6} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} |",
                row.pairs,
                row.touching,
                row.ties,
                row.thin,
                e.axis.max(0.0),
                e.normal,
                e.depth,
                e.off,
                e.area,
                e.extent,
            );
        }
        for failure in &self.failures {
            println!("{failure}");
        }
        let pairs: usize = self.rows.values().map(|row| row.pairs).sum();
        assert!(
            self.failed <= pairs / MISSED,
            "{} miss what is right",
            self.failed
        );
    }
}

fn kind(kind: [Feature; 2]) -> String {
    let name = |feature| match feature {
        Feature::Face => "face",
        Feature::Edge => "edge",
        Feature::Corner => "corner",
    };
    let mut names = kind.map(name);
    names.sort_unstable_by_key(|name| ["face", "edge", "corner"].iter().position(|n| n == name));
    format!("{} to {}", names[1], names[0])
}

/// As a mirror at x = 0 shows it.
fn mirrored((at, turn): Pose) -> Pose {
    (
        Vec3::new(-at.x, at.y, at.z),
        Quat::from_xyzw(turn.x, -turn.y, -turn.z, turn.w),
    )
}

pub const FAR: f64 = 1e3;

impl Pair<'_> {
    /// The pair in a mirror, of these shapes.
    fn mirrored<'a>(&self, [a, b]: &'a [Shape; 2]) -> Pair<'a> {
        Pair {
            shapes: [a, b],
            poses: self.poses.map(mirrored),
            kind: self.kind,
        }
    }
}

/// Looks at a pair from all sides.
fn judge(pair: &Pair, dice: &mut Dice, table: &mut Table) {
    let size = pair.shapes[0].form.size.min(pair.shapes[1].form.size);
    let reach = size * if dice.0.u32(..8) == 0 { 0.002 } else { FAR };
    let search = Search {
        reach,
        graze: f64::NEG_INFINITY,
    };
    let [a, b] = pair.shapes.map(|shape| &shape.body);
    let [at_a, at_b] = pair.poses;
    let look = |a: &Body, b: &Body, poses: [Pose; 2]| {
        let mut axis = Axis::Unknown;
        let contact = contact(a, b, poses, search, &mut axis);
        Seen::of(&contact, axis, poses[0])
    };
    let judge = Judge::new(pair, reach);
    let seen = look(a, b, pair.poses);
    let row = table.rows.entry(kind(pair.kind)).or_default();
    row.pairs += 1;
    row.touching += usize::from(!seen.points.is_empty());
    let mut wrong = |what: &str, judge: &Judge, view: &Seen, compared: bool| {
        let found = judge.errors(view).and_then(|errors| {
            row.errors.worst(&errors);
            row.thin += usize::from(errors.is_thin);
            match errors.too_large() {
                Some(what) => Err(what),
                None if compared => {
                    row.ties += usize::from(!judge.same(&seen, view)?);
                    Ok(())
                }
                None => Ok(()),
            }
        });
        let error = found.err()?;
        Some(format!("{what}: {error}, by {:?}", view.axis))
    };
    let mut wrongs = vec![wrong("as it is", &judge, &seen, false)];
    let swapped = look(b, a, [at_b, at_a]).exchanged();
    wrongs.push(wrong("swapped", &judge, &swapped, true));
    if swapped.axis == seen.axis
        && swapped.features() != seen.features()
        && !judge.can_stand_on_either(&seen)
    {
        wrongs.push(Some(format!(
            "swapped: other names {:x?} for {:x?}",
            swapped.features(),
            seen.features()
        )));
    }
    if dice.0.u32(..8) == 0 {
        let shapes = pair.shapes.map(Shape::mirrored);
        let mirror = pair.mirrored(&shapes);
        let judge_of_mirror = Judge::new(&mirror, reach);
        let view = look(&shapes[0].body, &shapes[1].body, mirror.poses);
        wrongs.push(wrong("in a mirror", &judge_of_mirror, &view, false));
        let view = view.mirrored();
        if let Err(error) = judge.same(&seen, &view) {
            wrongs.push(Some(format!("in a mirror not the same: {error}")));
        }
    }
    for i in 0..2 {
        let Some(hull) = pair.shapes[i].as_hull() else {
            continue;
        };
        let mut shapes = pair.shapes;
        shapes[i] = &hull;
        let as_hull = Pair { shapes, ..*pair };
        let judge_of_hull = Judge::new(&as_hull, reach);
        let view = look(&shapes[0].body, &shapes[1].body, pair.poses);
        wrongs.push(wrong("cuboid as hull", &judge_of_hull, &view, true));
    }
    for wrong in wrongs.into_iter().flatten() {
        let names = pair.shapes.map(|shape| shape.name);
        table.fails(format!(
            "{wrong}: {names:?} of {size:.2e} m, {}, most {:.2e}, reach {:.0e}, poses {:?}",
            kind(pair.kind),
            judge.truth.most() / size,
            reach / size,
            pair.poses
        ));
    }
}

/// So many pairs, of other shapes every few hundred.
fn run(seed: u64, count: usize) -> Table {
    let mut dice = Dice(Rng::with_seed(seed));
    let mut table = Table::default();
    let mut shapes = Vec::new();
    for i in 0..count {
        if i % 500 == 0 {
            shapes = dice.shapes(24);
        }
        let pair = dice.pair(&shapes);
        judge(&pair, &mut dice, &mut table);
    }
    table
}

#[test]
fn every_contact_is_right() {
    run(1, 20_000).holds();
}

#[test]
#[ignore = "long"]
fn every_contact_of_millions_is_right() {
    let count = std::env::var("DRYSTONE_PAIRS")
        .ok()
        .and_then(|n| n.parse().ok());
    let count: usize = count.unwrap_or(5_000_000);
    let mut table = Table::default();
    std::thread::scope(|scope| {
        let runs = [2, 3].map(|seed| scope.spawn(move || run(seed, count / 2)));
        for run in runs {
            table.add(run.join().expect("no contact panics"));
        }
    });
    table.holds();
}
