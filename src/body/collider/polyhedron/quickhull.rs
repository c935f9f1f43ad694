//! Computes the convex hull of points on a lattice, as triangles (quickhull).
//!
//! A point outside the hull replaces all facets that are visible from it by facets between itself and their rim. Visibility is computed
//! exactly, so the visible facets always form one patch with one rim, and the result is convex. A tolerance decides which points are added:
//! points hardly outside the hull are left out.

use glam::{DVec3, I64Vec3};

/// A triangle, counterclockwise as seen from outside.
pub(super) struct Facet {
    pub corners: [u32; 3],
    /// The facets across the edges from each corner to the next.
    pub beside: [u32; 3],
    /// Outward normal. Its length is twice the area of the triangle.
    pub normal: I64Vec3,
    /// Outward unit normal.
    unit: DVec3,
    /// Points outside it. Each point is assigned to one facet.
    outside: Vec<u32>,
    /// Points outside it by less than the tolerance.
    near: Vec<u32>,
    /// Whether it has been replaced.
    removed: bool,
}

impl Facet {
    fn new(points: &[I64Vec3], corners: [u32; 3]) -> Self {
        let [a, b, c] = corners.map(|i| points[i as usize]);
        let normal = (b - a).cross(c - a);
        Self {
            corners,
            beside: [0; 3],
            normal,
            unit: normal.as_dvec3().normalize(),
            outside: Vec::new(),
            near: Vec::new(),
            removed: false,
        }
    }

    fn away(&self, points: &[I64Vec3], point: u32) -> I64Vec3 {
        points[point as usize] - points[self.corners[0] as usize]
    }

    /// The signed distance of a point from the plane, in steps.
    fn height(&self, points: &[I64Vec3], point: u32) -> f64 {
        self.unit.dot(self.away(points, point).as_dvec3())
    }

    fn is_seen_from(&self, points: &[I64Vec3], point: u32) -> bool {
        let way = self.away(points, point);
        let part = |i: usize| i128::from(self.normal[i]) * i128::from(way[i]);
        part(0) + part(1) + part(2) > 0
    }

    /// Returns the farthest of the points outside. If several are equally far, as on a parallel face, returns the one with the greatest
    /// distance from a corner of the facet, because that one is a corner of the parallel face.
    fn farthest(&self, points: &[I64Vec3], slack: f64) -> Option<u32> {
        let heights = self.outside.iter().map(|&p| self.height(points, p));
        let limit = heights.fold(0.0, f64::max) - slack;
        let high = self.outside.iter().copied();
        high.filter(|&p| self.height(points, p) >= limit)
            .max_by_key(|&p| length_squared(self.away(points, p)))
    }

    /// The index of the side that begins at a corner.
    fn side_from(&self, corner: u32) -> usize {
        usize::from(corner == self.corners[1]) + 2 * usize::from(corner == self.corners[2])
    }
}

fn length_squared(v: I64Vec3) -> i64 {
    v.dot(v)
}

/// Computes the facets of the hull. Returns `None` if the points are in one plane. Points outside it by less than `slack` (steps) are left
/// out.
pub(super) fn hull(points: &[I64Vec3], slack: f64) -> Option<Vec<Facet>> {
    let mut facets = simplex(points, slack)?;
    let all = (0..points.len() as u32).collect();
    let mut open = assign_points(points, &mut facets, 0, all, slack);
    let mut starting = vec![0; points.len()];
    while !open.is_empty() {
        while let Some(i) = open.pop() {
            if facets[i].removed {
                continue;
            }
            let Some(apex) = facets[i].farthest(points, slack) else {
                continue;
            };
            let (rim, mut orphans) = remove_visible_facets(points, &mut facets, i as u32, apex);
            let first = facets.len();
            add_facets(points, &mut facets, &rim, apex, &mut starting);
            orphans.retain(|&p| p != apex);
            open.extend(assign_points(points, &mut facets, first, orphans, slack));
        }
        open = reassign_near_points(points, &mut facets, slack);
    }
    Some(compact(facets))
}

/// Finds four points that enclose a volume, and returns the facets between them.
fn simplex(points: &[I64Vec3], slack: f64) -> Option<Vec<Facet>> {
    let all = || 0..points.len() as u32;
    let at = |i: u32| points[i as usize];
    // The point farthest from any other is a corner.
    let a = all().max_by_key(|&i| length_squared(at(i)))?;
    let b = all().max_by_key(|&i| length_squared(at(i) - at(a)))?;
    let along = (at(b) - at(a)).as_dvec3().try_normalize()?;
    let aside = |i: &u32| (at(*i) - at(a)).as_dvec3().cross(along).length();
    let c = all().max_by(|i, j| aside(i).total_cmp(&aside(j)))?;
    if aside(&c) <= 2.0 * slack {
        return None;
    }
    let base = Facet::new(points, [a, b, c]);
    let height = |i: &u32| base.height(points, *i);
    let d = all().max_by(|i, j| height(i).abs().total_cmp(&height(j).abs()))?;
    if height(&d).abs() <= 2.0 * slack {
        return None;
    }
    let [b, c] = if height(&d) > 0.0 { [c, b] } else { [b, c] };
    let mut facets = [[a, b, c], [b, a, d], [c, b, d], [a, c, d]].map(|f| Facet::new(points, f));
    facets[0].beside = [1, 2, 3];
    facets[1].beside = [0, 3, 2];
    facets[2].beside = [0, 1, 3];
    facets[3].beside = [0, 2, 1];
    Some(facets.into())
}

/// Assigns each point to the first facet from `first` on that it is outside of. A point that is outside of no facet is inside the hull.
/// Returns the facets that got points beyond the tolerance.
fn assign_points(
    points: &[I64Vec3],
    facets: &mut [Facet],
    first: usize,
    orphans: Vec<u32>,
    slack: f64,
) -> Vec<usize> {
    let mut homes = Vec::new();
    for point in orphans {
        let mut near = None;
        let home = (first..facets.len()).find(|&i| {
            let height = facets[i].height(points, point);
            if height > 0.0 {
                near.get_or_insert(i);
            }
            height > slack
        });
        if let Some(home) = home {
            facets[home].outside.push(point);
            homes.push(home);
        } else if let Some(near) = near {
            facets[near].near.push(point);
        }
    }
    homes.dedup();
    homes
}

/// Assigns points within the tolerance of their facet anew: near a sharp edge, such a point may be far outside of a facet behind the edge.
/// Returns the facets that got points.
fn reassign_near_points(points: &[I64Vec3], facets: &mut [Facet], slack: f64) -> Vec<usize> {
    let mut homes = Vec::new();
    for i in 0..facets.len() {
        for point in std::mem::take(&mut facets[i].near) {
            match find_visible_facet(points, facets, i, point, slack) {
                Some(home) => {
                    facets[home].outside.push(point);
                    homes.push(home);
                }
                None => facets[i].near.push(point),
            }
        }
    }
    homes
}

/// Searches for a facet that a point is outside of by more than the tolerance. The search starts at a visible facet, because the visible
/// facets are connected.
fn find_visible_facet(
    points: &[I64Vec3],
    facets: &[Facet],
    from: usize,
    point: u32,
    slack: f64,
) -> Option<usize> {
    let mut seen = vec![from];
    let mut done = 0;
    while let Some(&i) = seen.get(done) {
        done += 1;
        for other in facets[i].beside.map(|other| other as usize) {
            let height = facets[other].height(points, point);
            if height > slack {
                return Some(other);
            }
            if height > 0.0 && !seen.contains(&other) {
                seen.push(other);
            }
        }
    }
    None
}

/// Removes all facets that are visible from a point. Returns their rim, as the facets outside it and the index of the side, and their
/// points.
fn remove_visible_facets(
    points: &[I64Vec3],
    facets: &mut [Facet],
    seen: u32,
    apex: u32,
) -> (Vec<(u32, usize)>, Vec<u32>) {
    let (mut rim, mut orphans) = (Vec::new(), Vec::new());
    let mut open = vec![seen];
    facets[seen as usize].removed = true;
    while let Some(i) = open.pop() {
        let facet = &mut facets[i as usize];
        orphans.append(&mut std::mem::take(&mut facet.outside));
        orphans.append(&mut std::mem::take(&mut facet.near));
        let (beside, corners) = (facet.beside, facet.corners);
        for side in 0..3 {
            let other = &mut facets[beside[side] as usize];
            if other.removed {
                continue;
            }
            if other.is_seen_from(points, apex) {
                other.removed = true;
                open.push(beside[side]);
            } else {
                rim.push((beside[side], other.side_from(corners[(side + 1) % 3])));
            }
        }
    }
    (rim, orphans)
}

/// Adds the facets between a point and the rim. `starting` is scratch: for each point, the new facet whose rim edge starts there.
fn add_facets(
    points: &[I64Vec3],
    facets: &mut Vec<Facet>,
    rim: &[(u32, usize)],
    apex: u32,
    starting: &mut [u32],
) {
    let first = facets.len();
    for &(below, side) in rim {
        let corners = facets[below as usize].corners;
        let (from, to) = (corners[(side + 1) % 3], corners[side]);
        let new = facets.len() as u32;
        starting[from as usize] = new;
        facets[below as usize].beside[side] = new;
        let mut facet = Facet::new(points, [from, to, apex]);
        facet.beside[0] = below;
        facets.push(facet);
    }
    for i in first..facets.len() {
        let next = starting[facets[i].corners[1] as usize];
        facets[i].beside[1] = next;
        facets[next as usize].beside[2] = i as u32;
    }
}

/// Drops the facets that were removed, and renumbers the others.
fn compact(facets: Vec<Facet>) -> Vec<Facet> {
    let mut count = 0;
    let place: Vec<u32> = facets
        .iter()
        .map(|facet| {
            count += u32::from(!facet.removed);
            count.wrapping_sub(1)
        })
        .collect();
    let mut left: Vec<Facet> = facets.into_iter().filter(|facet| !facet.removed).collect();
    for facet in &mut left {
        facet.beside = facet.beside.map(|i| place[i as usize]);
    }
    left
}
