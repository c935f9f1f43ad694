//! Small changes that nothing resists.
//!
//! A feather tips a seesaw however heavy it is, because its hinge resists nothing. So changes that are too small to wake a body by
//! themselves are followed down to the ground every quarter of a second, from the bodies that awake ones touch on. Each sleeping body
//! passes its change on to what holds it up. Each contact point takes a part of it in proportion to its *reserve*: its normal force, and
//! what friction can still bear. These parts balance the change, and are the smallest by least squares. A body wakes with all that rests on
//! it if a part takes more than half of a reserve, if nothing balances the change, or if a joint holds it that is no mortar: it may be at
//! its limit, and shows it when it is awake.
//!
//! With reserves as weights a body that stands on two rows of points is at its limit where statics tips it. If it stands on more, a point
//! may be unloaded earlier; then the body wakes, stands, and sleeps again.

use super::{Need, Rising};
use crate::body::BodyState;
use crate::graph::edges::{EdgeKind, Link};
use crate::graph::waking::Accounts;
use crate::pair::{ContactImpulses, ContactPair, Manifold, Wrench};
use crate::solver::sort;
use bevy_platform::collections::HashMap;
use glam::Vec3;
use smallvec::SmallVec;

/// Share of what presses on a body that a joint holds below which a change does not count.
const JOINED_CHANGE_SHARE: f32 = 1e-4;

/// The same for a body that an awake one touches.
const TOUCHED_CHANGE_SHARE: f32 = 5e-4;

/// The same for other bodies: further down more presses on each body, and more bodies share the change.
const PASSED_CHANGE_SHARE: f32 = 1e-2;

/// Share of a reserve that may be taken.
const TAKEN_SHARE: f32 = 0.5;

/// A reserve below this share of what presses on a body may be used up: others remain.
const LITTLE_RESERVE: f32 = 2e-3;

/// A change is followed over at most this many bodies down. Bodies that it has not left by then wake.
const MAX_DEPTH: usize = 256;

/// A force or moment that can balance a change: a unit of it on the body, with the reserve, N.
struct Row {
    force: Vec3,
    /// About the centre of mass, divided by the radius of the body.
    moment: Vec3,
    reserve: f32,
    /// A contact can press more, but not less than nothing.
    is_normal: bool,
    /// The slot of the body that takes the opposite, and the arm there, m.
    by: (u32, Vec3),
}

/// A force, N, and a moment about the centre of mass, N·m.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    force: Vec3,
    moment: Vec3,
}

impl Change {
    fn add(&mut self, other: &Self) {
        self.force += other.force;
        self.moment += other.moment;
    }

    /// N.
    fn size(&self, radius: f32) -> f32 {
        self.force.length() + self.moment.length() / radius
    }
}

/// How the forces on a body have changed.
struct Followed {
    total: Change,
    /// The change of force that has not been passed on yet.
    rest: Change,
    /// Sum of the normal forces on the body, N.
    normal_force: f32,
    /// The share of that below which the rest does not count.
    least: f32,
}

impl Need<'_, '_, '_> {
    /// Follows how the forces on sleeping bodies beside awake ones have changed since their accounts were opened, and wakes the bodies that
    /// may not bear it.
    pub fn wake_unsteady(
        &self,
        boundary: &[u32],
        accounts: &Accounts,
        share: f32,
        rising: &mut Rising,
    ) {
        let up = -self.gravity.normalize_or_zero();
        let mut found: HashMap<u32, Followed> = HashMap::default();
        let mut level: Vec<(u32, Change)> = boundary
            .iter()
            .map(|&slot| (slot, Change::default()))
            .collect();
        for depth in 0.. {
            // Two bodies may have a support in common. The order of the sums must not depend on history, as that of slots does.
            let order = |slot| self.table.get(slot).map(|body| body.spawn_order);
            sort::by_key(&mut level, |&(slot, _)| order(slot));
            level.dedup_by(|one, before| {
                let is_same = one.0 == before.0;
                if is_same {
                    before.1.add(&one.1);
                }
                is_same
            });
            let mut below = Vec::new();
            for (slot, change) in level {
                let sleeps = |body: &&BodyState| body.is_dynamic() && body.asleep;
                let Some(body) = self.table.get(slot).filter(sleeps) else {
                    continue;
                };
                if rising.contains(slot) {
                    continue;
                }
                let of = found.entry(slot).or_insert_with(|| {
                    let now = self.wrench(slot);
                    let own = accounts
                        .get(slot)
                        .map_or_else(Change::default, |then| Change {
                            force: now.force - then.force,
                            moment: now.moment - then.moment,
                        });
                    let at_boundary = depth == 0;
                    Followed {
                        total: own,
                        // The changes by other bodies were passed on then.
                        rest: if at_boundary { own } else { Change::default() },
                        normal_force: self.normal_force(body, &now),
                        least: match (self.is_jointed(slot), at_boundary) {
                            (true, _) => JOINED_CHANGE_SHARE,
                            (false, true) => TOUCHED_CHANGE_SHARE,
                            (false, false) => PASSED_CHANGE_SHARE,
                        },
                    }
                });
                of.total.add(&change);
                of.rest.add(&change);
                if of.rest.size(body.radius) <= of.least * of.normal_force {
                    continue;
                }
                let last = std::mem::take(&mut of.rest);
                let parts = [&of.total, &last];
                if self.stands_on_awake(slot, up) {
                    rising.add(self.table, slot);
                } else if depth == MAX_DEPTH
                    || !self.pass_on((slot, body), of.normal_force, up, parts, &mut below)
                {
                    rising.add(self.table, slot);
                    self.wake_resting(slot, share, rising);
                }
            }
            if below.is_empty() {
                break;
            }
            level = below;
        }
    }

    fn is_jointed(&self, slot: u32) -> bool {
        self.graph
            .edges_of_kind(slot, EdgeKind::Joint)
            .next()
            .is_some()
    }

    /// Passes the last part of a change on to the bodies that hold a body up. Returns false if these may not bear all of it.
    fn pass_on(
        &self,
        (slot, body): (u32, &BodyState),
        normal_force: f32,
        up: Vec3,
        [total, last]: [&Change; 2],
        below: &mut Vec<(u32, Change)>,
    ) -> bool {
        let mut links: SmallVec<[Link; 16]> = self.graph.links_of(slot).collect();
        let mut joints = links.iter().filter(|link| link.kind == EdgeKind::Joint);
        if joints.clone().next().is_some() {
            // Mortar bears it; other joints may not.
            return joints.all(|joint| self.is_bond(joint));
        }
        let order = |link: &Link| {
            self.table
                .get(link.other(slot))
                .map(|body| body.spawn_order)
        };
        sort::by_key(&mut links, order);
        let mut rows = SmallVec::<[Row; 32]>::new();
        for link in &links {
            self.add_rows(link, (slot, body), up, &mut rows);
        }
        let balance = |change: &Change| {
            let of = [change.force, change.moment / body.radius].map(|part| -part);
            solve(&rows, JOINED_CHANGE_SHARE * normal_force, of)
        };
        let [force, moment] = balance(total);
        if force.length_squared() + moment.length_squared() > 1.0 {
            return false;
        }
        let is_taken = |row: &Row| {
            let share = row.force.dot(force) + row.moment.dot(moment);
            let is_taken = share < -TAKEN_SHARE || !row.is_normal && share > TAKEN_SHARE;
            is_taken && row.reserve > LITTLE_RESERVE * normal_force
        };
        if rows.iter().any(is_taken) {
            return false;
        }
        let [force, moment] = balance(last);
        for row in &rows {
            let (other, arm) = row.by;
            let taken = row.reserve * (row.force.dot(force) + row.moment.dot(moment));
            let force = -taken * row.force;
            let passed = Change {
                force,
                moment: arm.cross(force),
            };
            match below.last_mut().filter(|(slot, _)| *slot == other) {
                Some((_, known)) => known.add(&passed),
                None => below.push((other, passed)),
            }
        }
        true
    }

    /// Adds what can balance a change at a contact, if that holds the body up.
    fn add_rows(
        &self,
        link: &Link,
        (slot, body): (u32, &BodyState),
        up: Vec3,
        rows: &mut SmallVec<[Row; 32]>,
    ) {
        let other = link.other(slot);
        let Some(contact) = self.forces.contact(link) else {
            return;
        };
        let mut wrench = Wrench::default();
        wrench.add_contact(slot, contact);
        if wrench.force.dot(up) <= 0.0 {
            return;
        }
        let (pair, manifold, impulses) = contact;
        let is_a = pair.slots[0] == slot;
        for (number, patch, range) in manifold.patches_with_points() {
            let normal = patch.normal;
            let slack = slack(contact, number, range.clone());
            let tangent = normal.any_orthonormal_vector();
            let tangents = [tangent, normal.cross(tangent)];
            for i in range {
                let Some(point) = impulses.points.get(i).filter(|of| of.normal_force > 0.0) else {
                    continue;
                };
                let [at_a, at_b] = manifold.arms(i);
                let (arm, by) = if is_a { (at_a, at_b) } else { (at_b, at_a) };
                let mut add = |force: Vec3, reserve: f32, is_normal| {
                    rows.push(Row {
                        force,
                        moment: arm.cross(force) / body.radius,
                        reserve,
                        is_normal,
                        by: (other, by),
                    });
                };
                add(
                    if is_a { normal } else { -normal },
                    point.normal_force,
                    true,
                );
                for tangent in tangents {
                    add(tangent, slack * point.normal_force, false);
                }
            }
        }
    }

    /// Returns true if all that holds a body up is awake. Then it is a weight that cannot be moved to these bodies, and hides from them
    /// that they tip.
    fn stands_on_awake(&self, slot: u32, up: Vec3) -> bool {
        let each = self.forces.each(slot, self.graph);
        let mut holding = each.iter().filter(|(_, wrench)| wrench.force.dot(up) > 0.0);
        let is_awake = |slot: u32| self.table.get(slot).is_some_and(BodyState::is_awake);
        holding.clone().next().is_some() && holding.all(|&(other, _)| is_awake(other))
    }

    fn is_bond(&self, link: &Link) -> bool {
        let joint = self.joints.get(link.pair);
        joint.is_ok_and(|joint| joint.definition.section.is_some())
    }
}

/// The friction that a patch can still bear, as a share of the normal force.
fn slack(
    (pair, _, impulses): (&ContactPair, &Manifold, &ContactImpulses),
    patch: usize,
    range: std::ops::Range<usize>,
) -> f32 {
    let points = impulses.points.get(range.clone()).unwrap_or_default();
    let pressed: f32 = points.iter().map(|point| point.normal_force).sum();
    let points = impulses.friction.get(range).unwrap_or_default();
    let mut borne: Vec3 = points.iter().map(|point| point.friction_force).sum();
    borne += impulses
        .patches
        .get(patch)
        .map_or(Vec3::ZERO, |of| of.friction_force);
    (pair.friction - borne.length() / pressed.max(f32::MIN_POSITIVE)).max(0.0)
}

/// The smallest shares of their reserves, by least squares, with which rows give a body a force and a moment, N: those of a row are its
/// force and its moment times the two vectors that are returned. The rest is left to a reserve of `least` in all
/// directions, N.
fn solve(rows: &[Row], least: f32, [force, moment]: [Vec3; 2]) -> [Vec3; 2] {
    let mut a = [[0.0_f32; 7]; 6];
    for row in rows {
        let of: [f32; 6] = std::array::from_fn(|i| {
            if i < 3 {
                row.force[i]
            } else {
                row.moment[i - 3]
            }
        });
        for i in 0..6 {
            let weighted = row.reserve * of[i];
            for (sum, of) in a[i].iter_mut().zip(of) {
                *sum += weighted * of;
            }
        }
    }
    for i in 0..6 {
        a[i][i] += least.max(f32::MIN_POSITIVE);
        a[i][6] = if i < 3 { force[i] } else { moment[i - 3] };
    }
    // Without pivoting, which a positive definite matrix does not need.
    for i in 0..6 {
        let (done, below) = a.split_at_mut(i + 1);
        let pivot = &done[i];
        for row in below {
            let factor = row[i] / pivot[i];
            for (entry, of_pivot) in row[i..].iter_mut().zip(&pivot[i..]) {
                *entry -= factor * of_pivot;
            }
        }
    }
    let mut x = [0.0_f32; 6];
    for i in (0..6).rev() {
        let known: f32 = (i + 1..6).map(|j| a[i][j] * x[j]).sum();
        x[i] = (a[i][6] - known) / a[i][i];
    }
    [Vec3::new(x[0], x[1], x[2]), Vec3::new(x[3], x[4], x[5])]
}
