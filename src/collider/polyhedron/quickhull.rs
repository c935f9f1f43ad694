//! The hull of points on a lattice, as triangles.
//!
//! A point that sees a facet from outside takes the place of all facets it sees. Which it sees is exact, so that they are always
//! one patch with one rim, and what comes of it is convex. Which points are worth taking is not: those hardly outside are left
//! out.

use glam::{DVec3, I64Vec3};

/// A triangle, counterclockwise as seen from outside.
pub(super) struct Facet {
    pub corners: [u32; 3],
    /// The facets across the edges from each corner to the next.
    pub beside: [u32; 3],
    /// The way out, as long as twice its area.
    pub normal: I64Vec3,
    /// The same, of unit length.
    unit: DVec3,
    /// Points that see it, each of them with one facet only.
    outside: Vec<u32>,
    /// Points that see it, but are outside of it by next to nothing.
    near: Vec<u32>,
    gone: bool,
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
            gone: false,
        }
    }

    fn away(&self, points: &[I64Vec3], point: u32) -> I64Vec3 {
        points[point as usize] - points[self.corners[0] as usize]
    }

    /// How far a point is outside, in steps.
    fn height(&self, points: &[I64Vec3], point: u32) -> f64 {
        self.unit.dot(self.away(points, point).as_dvec3())
    }

    fn is_seen_from(&self, points: &[I64Vec3], point: u32) -> bool {
        let way = self.away(points, point);
        let part = |i: usize| i128::from(self.normal[i]) * i128::from(way[i]);
        part(0) + part(1) + part(2) > 0
    }

    /// The point furthest outside. Of a face that lies parallel all points are; then that which is furthest from a corner, and so
    /// is one itself.
    fn furthest(&self, points: &[I64Vec3], slack: f64) -> Option<u32> {
        let heights = self.outside.iter().map(|&p| self.height(points, p));
        let limit = heights.fold(0.0, f64::max) - slack;
        let high = self.outside.iter().copied();
        high.filter(|&p| self.height(points, p) >= limit)
            .max_by_key(|&p| length_squared(self.away(points, p)))
    }

    fn side_from(&self, corner: u32) -> usize {
        usize::from(corner == self.corners[1]) + 2 * usize::from(corner == self.corners[2])
    }
}

fn length_squared(v: I64Vec3) -> i64 {
    v.dot(v)
}

/// The facets of the hull; none where the points are in one plane. Points outside it by less than `slack`, in steps, are left out.
pub(super) fn hull(points: &[I64Vec3], slack: f64) -> Option<Vec<Facet>> {
    let mut facets = simplex(points, slack)?;
    let all = (0..points.len() as u32).collect();
    let mut open = share_out(points, &mut facets, 0, all, slack);
    let mut starting = vec![0; points.len()];
    while !open.is_empty() {
        while let Some(i) = open.pop() {
            if facets[i].gone {
                continue;
            }
            let Some(apex) = facets[i].furthest(points, slack) else {
                continue;
            };
            let (rim, mut orphans) = take_off(points, &mut facets, i as u32, apex);
            let first = facets.len();
            put_on(points, &mut facets, &rim, apex, &mut starting);
            orphans.retain(|&p| p != apex);
            open.extend(share_out(points, &mut facets, first, orphans, slack));
        }
        open = look_beyond(points, &mut facets, slack);
    }
    Some(without_gaps(facets))
}

/// Four points with volume between them.
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

/// Each point goes to a facet it sees, from the first one given on; if it sees none it is inside the hull. Returns the facets that
/// points are well outside of.
fn share_out(
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

/// At a sharp edge, what is hardly outside of a facet may be well outside of one behind it. Returns such, with the points.
fn look_beyond(points: &[I64Vec3], facets: &mut [Facet], slack: f64) -> Vec<usize> {
    let mut homes = Vec::new();
    for i in 0..facets.len() {
        for point in std::mem::take(&mut facets[i].near) {
            match beyond(points, facets, i, point, slack) {
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

/// A facet that a point is well outside of, if there is one. All that it sees hang together.
fn beyond(
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

/// Takes off all facets that a point sees. Returns the rim they leave, as facets and which of their sides, and their points.
fn take_off(
    points: &[I64Vec3],
    facets: &mut [Facet],
    seen: u32,
    apex: u32,
) -> (Vec<(u32, usize)>, Vec<u32>) {
    let (mut rim, mut orphans) = (Vec::new(), Vec::new());
    let mut open = vec![seen];
    facets[seen as usize].gone = true;
    while let Some(i) = open.pop() {
        let facet = &mut facets[i as usize];
        orphans.append(&mut std::mem::take(&mut facet.outside));
        orphans.append(&mut std::mem::take(&mut facet.near));
        let (beside, corners) = (facet.beside, facet.corners);
        for side in 0..3 {
            let other = &mut facets[beside[side] as usize];
            if other.gone {
                continue;
            }
            if other.is_seen_from(points, apex) {
                other.gone = true;
                open.push(beside[side]);
            } else {
                rim.push((beside[side], other.side_from(corners[(side + 1) % 3])));
            }
        }
    }
    (rim, orphans)
}

/// Joins a point to the rim. `starting` is for finding the facet whose edge of the rim starts at a point.
fn put_on(
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

fn without_gaps(facets: Vec<Facet>) -> Vec<Facet> {
    let mut count = 0;
    let place: Vec<u32> = facets
        .iter()
        .map(|facet| {
            count += u32::from(!facet.gone);
            count.wrapping_sub(1)
        })
        .collect();
    let mut left: Vec<Facet> = facets.into_iter().filter(|facet| !facet.gone).collect();
    for facet in &mut left {
        facet.beside = facet.beside.map(|i| place[i as usize]);
    }
    left
}
