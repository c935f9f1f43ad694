//! Pictures of contacts that are hard to get right, seen along their normals, in `target/pictures/contact`.
//!
//! ```text
//! cargo run --release --example contact
//! ```

use drystone::collider::Polyhedron;
use drystone::narrowphase::polyhedra::{
    Axis, Contact, Cuboid, FeatureId, Placement, Search, Solid, Triangle, facing, meet, outline,
};
use drystone_lab::plots::{Canvas, bring_font};
use glam::{DQuat, DVec3, Vec3};
use plotters::prelude::*;
use std::error::Error;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::path::Path;

/// Pixels: the picture, the margin that labels need, and the heading.
const SIZE: (u32, u32) = (1000, 820);
const MARGIN: f64 = 130.0;
const HEAD: f64 = 40.0;

const OF_A: RGBColor = RGBColor(20, 90, 200);
const OF_B: RGBColor = RGBColor(225, 110, 0);
const COMMON: RGBColor = RGBColor(120, 190, 120);

/// A contact as it is drawn, in the frame of A.
struct View {
    normal: DVec3,
    /// The face of each, or its edge where edges cross.
    faces: [Vec<DVec3>; 2],
    polygon: Vec<DVec3>,
    /// Points kept, and their labels.
    kept: Vec<(DVec3, String)>,
}

fn view<A: Solid, B: Solid>(a: &A, b: &B, place: Placement) -> View {
    let search = Search {
        reach: 0.05,
        graze: f64::NEG_INFINITY,
    };
    let mut axis = Axis::Unknown;
    let mut contact = Contact::default();
    meet(a, b, &place, search, &mut axis, &mut contact);
    let (normal, back) = (-contact.normal, place.back(contact.normal));
    let face_a = match axis {
        Axis::FaceOfA(face) => face,
        _ => facing(a, normal),
    };
    let face_b = match axis {
        Axis::FaceOfB(face) => face,
        _ => facing(b, back),
    };
    let faces = match axis {
        Axis::Edges(i, j) => [
            a.edge(i).ends.map(|end| a.point(end)).to_vec(),
            b.edge(j).ends.map(|end| place.point(b.point(end))).to_vec(),
        ],
        _ => [
            outline(a, face_a).map(|corner| corner.0).collect(),
            outline(b, face_b)
                .map(|corner| place.point(corner.0))
                .collect(),
        ],
    };
    let polygon = contact.points.iter().map(|point| point.position).collect();
    contact.simplify(4, |_| false);
    let label = |feature, distance: f64| format!("{} {:+.2} mm", name(feature), 1e3 * distance);
    let kept = contact.points.iter();
    View {
        normal,
        faces,
        polygon,
        kept: kept
            .map(|p| (p.position, label(p.feature, p.distance)))
            .collect(),
    }
}

/// The features of a point: a corner of one, or edges of both.
fn name(feature: FeatureId) -> String {
    let (a, b) = ((feature.0 >> 15) & 0x7FFF, feature.0 & 0x7FFF);
    match feature.0 >> 30 {
        1 => format!("A{a}"),
        2 => format!("B{b}"),
        _ => format!("a{a}×b{b}"),
    }
}

/// Where pictures are drawn.
type Area<'a> = DrawingArea<Canvas<'a>, plotters::coord::Shift>;

fn draw(path: &Path, title: &str, views: &[View]) -> Result<(), Box<dyn Error>> {
    let normal = views[0].normal;
    // The longest side of the first face lies.
    let face = &views[0].faces[0];
    let side = |i: usize| face[(i + 1) % face.len()] - face[i];
    let longest = (0..face.len())
        .map(side)
        .max_by(|u, v| u.length().total_cmp(&v.length()));
    let u = longest.unwrap_or(DVec3::X).reject_from(normal).normalize();
    let v = normal.cross(u);
    let flat = |at: &DVec3| (at.dot(u), at.dot(v));
    let all: Vec<_> = views
        .iter()
        .flat_map(|view| view.faces.iter().flatten())
        .map(flat)
        .collect();
    let range = |of: fn(&(f64, f64)) -> f64| {
        let values = all.iter().map(of);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        })
    };
    let ((left, right), (low, high)) = (range(|p| p.0), range(|p| p.1));
    let (width, height) = (
        SIZE.0 as f64 - 2.0 * MARGIN,
        SIZE.1 as f64 - 2.0 * MARGIN - HEAD,
    );
    let scale = (width / (right - left).max(1e-6)).min(height / (high - low).max(1e-6));
    let pixel = |at: &DVec3| {
        let (x, y) = flat(at);
        let x = 0.5 * SIZE.0 as f64 + scale * (x - 0.5 * (left + right));
        let y = 0.5 * (SIZE.1 as f64 + HEAD) - scale * (y - 0.5 * (low + high));
        (x.round() as i32, y.round() as i32)
    };
    let area = Canvas::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    for view in views {
        let polygon: Vec<_> = view.polygon.iter().map(pixel).collect();
        if polygon.len() > 2 {
            area.draw(&Polygon::new(polygon, COMMON.mix(0.45).filled()))?;
        }
    }
    for view in views {
        // One inside the other's line shows where they coincide.
        for (face, color, width) in [(&view.faces[0], OF_A, 7), (&view.faces[1], OF_B, 2)] {
            let back = face.first().filter(|_| face.len() > 2);
            let round = face.iter().chain(back).map(pixel);
            area.draw(&PathElement::new(
                round.collect::<Vec<_>>(),
                color.stroke_width(width),
            ))?;
        }
    }
    for view in views {
        draw_points(&area, view, pixel)?;
    }
    area.draw(&Text::new(
        title.to_owned(),
        (20, 14),
        ("sans-serif", 26).into_font(),
    ))?;
    draw_key(&area)?;
    area.present()?;
    Ok(())
}

/// The corners of the polygon, and the points that are kept, with their names.
fn draw_points(
    area: &Area,
    view: &View,
    pixel: impl Fn(&DVec3) -> (i32, i32),
) -> Result<(), Box<dyn Error>> {
    for at in &view.polygon {
        area.draw(&Circle::new(pixel(at), 5, BLACK.stroke_width(1)))?;
    }
    let middle = view.polygon.iter().sum::<DVec3>() / view.polygon.len().max(1) as f64;
    let center = pixel(&middle);
    for (at, label) in &view.kept {
        let at = pixel(at);
        area.draw(&Circle::new(at, 7, BLACK.filled()))?;
        let wide = 8 * label.chars().count() as i32;
        // Outwards, or above the only one.
        let x = if at.0 < center.0 {
            at.0 - wide - 12
        } else {
            at.0 + 14
        };
        let y = if at.1 > center.1 {
            at.1 + 10
        } else {
            at.1 - 28
        };
        let x = x.clamp(5, SIZE.0 as i32 - wide - 5);
        area.draw(&Text::new(
            label.clone(),
            (x, y),
            ("sans-serif", 18).into_font(),
        ))?;
    }
    Ok(())
}

/// What lines and points mean.
fn draw_key(area: &Area) -> Result<(), Box<dyn Error>> {
    let bottom = SIZE.1 as i32 - 30;
    let key = [
        ("face or edge of A", OF_A, 7, 20),
        ("of B", OF_B, 2, 270),
        ("in common", COMMON, 14, 420),
    ];
    for (text, color, width, x) in key {
        area.draw(&PathElement::new(
            [(x, bottom), (x + 40, bottom)],
            color.stroke_width(width),
        ))?;
        area.draw(&Text::new(
            text,
            (x + 50, bottom - 10),
            ("sans-serif", 18).into_font(),
        ))?;
    }
    area.draw(&Circle::new((610, bottom), 5, BLACK.stroke_width(1)))?;
    area.draw(&Text::new(
        "corner of it",
        (625, bottom - 10),
        ("sans-serif", 18).into_font(),
    ))?;
    area.draw(&Circle::new((770, bottom), 7, BLACK.filled()))?;
    area.draw(&Text::new(
        "kept, overlap < 0",
        (785, bottom - 10),
        ("sans-serif", 18).into_font(),
    ))?;
    Ok(())
}

fn at(x: f64, y: f64, z: f64) -> Placement {
    Placement::new(DVec3::new(x, y, z), DQuat::IDENTITY)
}

fn hull(points: impl IntoIterator<Item = DVec3>) -> Polyhedron {
    let points: Vec<_> = points.into_iter().map(|p| p.as_vec3()).collect();
    Polyhedron::new(&points).expect("it has volume")
}

/// A prism along y of so many sides, that lies on one of its ends.
fn prism(sides: usize, radius: f64) -> Polyhedron {
    let around = |i: usize| std::f64::consts::TAU * i as f64 / sides as f64;
    hull((0..2 * sides).map(|i| {
        let y = if i < sides { -0.5 } else { 0.5 };
        DVec3::new(radius * around(i).cos(), y, radius * around(i).sin())
    }))
}

/// Part of a ring about z, so many degrees wide, from the middle upwards.
fn voussoir(degrees: f64) -> Polyhedron {
    let corner = |i: u32| {
        let angle = FRAC_PI_2 + (if i & 1 == 0 { -0.5 } else { 0.5 }) * degrees.to_radians();
        let radius = if i & 2 == 0 { 1.0 } else { 1.3 };
        let z = if i & 4 == 0 { -0.2 } else { 0.2 };
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    hull((0..8).map(corner))
}

/// The pictures: name, title and views.
fn pictures() -> Vec<(&'static str, &'static str, Vec<View>)> {
    let cube = Cuboid::new(Vec3::splat(0.5));
    let brick = Cuboid::new(Vec3::new(0.5, 0.25, 0.25));
    let turned = |angle: f64| {
        let up = DVec3::Y * 0.9999;
        view(
            &cube,
            &cube,
            Placement::new(up, DQuat::from_rotation_y(angle)),
        )
    };
    let sunk = 0.4999;
    let triangle = Triangle::new([
        Vec3::new(0.5, 0.5, 0.5),
        Vec3::new(0.1, 0.5, -1.0),
        Vec3::new(1.2, 0.5, 0.2),
    ]);
    let triangle = triangle.expect("its corners are not on a line");
    let across = DQuat::from_rotation_y(1.1) * DQuat::from_rotation_x(FRAC_PI_4);
    let below = Placement::new(DVec3::Y * (2.0 * 0.5f64.sqrt() - 1e-4), across);
    let mut rng = fastrand::Rng::with_seed(3);
    let mut round = || DVec3::from_array(std::array::from_fn(|_| rng.f64() - 0.5)).normalize();
    let round = hull((0..24).map(|_| 0.6 * round()).collect::<Vec<_>>());
    let tilt = DQuat::from_rotation_x(13.27f64.to_radians()) * DQuat::from_rotation_y(0.4);
    let lowest = -round.reach(-(tilt.inverse() * DVec3::Y));
    let standing = Placement::new(DVec3::Y * (0.5 - 2e-4 - lowest), tilt);
    let wedge = voussoir(12.0);
    let joint = DQuat::from_rotation_z(-12.01f64.to_radians()) * DQuat::from_rotation_y(0.004);
    vec![
        (
            "squares-1",
            "Equal squares, turned by 1°",
            vec![turned(1f64.to_radians())],
        ),
        (
            "squares-45",
            "Equal squares, turned by 45°",
            vec![turned(FRAC_PI_4)],
        ),
        ("squares", "Equal squares that coincide", vec![turned(0.0)]),
        (
            "flush",
            "Flush edges, half over each other",
            vec![view(&brick, &brick, at(0.5, sunk, 0.0))],
        ),
        (
            "seam",
            "A brick on the seam of two, flush",
            // Seen from the one on top, whose frame both have in common.
            vec![
                view(&brick, &brick, at(-0.5, -sunk, 0.0)),
                view(&brick, &brick, at(0.5, -sunk, 0.0)),
            ],
        ),
        (
            "corners",
            "A triangle's corner on a corner",
            vec![view(&cube, &triangle, at(0.0, -1e-4, 0.0))],
        ),
        (
            "prism",
            "A prism of 16 on a cube",
            vec![view(&cube, &prism(16, 0.6), at(0.1, 0.9999, 0.0))],
        ),
        (
            "edges",
            "An edge across an edge",
            vec![view(&rotated_cube(), &cube, below)],
        ),
        (
            "tilted",
            "A hull tilted by 13.27° on a cube",
            vec![view(&cube, &round, standing)],
        ),
        (
            "joint",
            "A joint of an arch, 0.01° open, twisted by 0.004",
            vec![view(&wedge, &wedge, Placement::new(DVec3::ZERO, joint))],
        ),
    ]
}

fn main() -> Result<(), Box<dyn Error>> {
    bring_font()?;
    let out = Path::new("target/pictures/contact");
    std::fs::create_dir_all(out)?;
    for (file, title, views) in pictures() {
        let path = out.join(format!("{file}.png"));
        draw(&path, title, &views)?;
        println!("{}", path.display());
    }
    Ok(())
}

/// On an edge.
fn rotated_cube() -> Polyhedron {
    let turn = DQuat::from_rotation_x(FRAC_PI_4);
    let corner = |i: u32| {
        let sign = |bit: u32| if i >> bit & 1 == 1 { 0.5 } else { -0.5 };
        turn * DVec3::new(sign(0), sign(1), sign(2))
    };
    hull((0..8).map(corner))
}
