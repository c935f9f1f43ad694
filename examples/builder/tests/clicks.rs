//! Tests with a simulated user: real clicks and keys on a real window, on a virtual display. The results are read from the builder's
//! journal; pictures of before and after are in `target/builder/`.
//!
//! `cargo test --ignore-rust-version --test clicks -- --nocapture`; it wants `Xvfb`, `xdotool` and a Vulkan driver (the README names
//! packages), and says so where they are missing.

use drystone_builder::journal::{Entry, Sight};
use glam::{Quat, Vec2, Vec3};
use std::cell::RefCell;
use std::collections::{BTreeSet, VecDeque};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

/// A brick is where it was put, m.
const THERE: f32 = 5e-3;

/// Maximum time that a software renderer takes to answer, s.
const PATIENCE: u64 = 90;

/// The root of the repository: `target/builder/` is there.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

#[test]
fn a_person_builds_presses_takes_and_undoes() {
    let Some(desk) = Desk::new() else {
        return;
    };
    let start = desk.look();
    assert_eq!(start.bodies.len(), 13);
    desk.picture("1-before");

    // A brick from the palette, laid over the joint of two.
    desk.click(widget(&start, "Brick"));
    desk.click(start.on_screen(Vec3::new(-1.3, 1.0, 0.1)));
    let laid = desk.wait("the brick is laid", |entry| match entry {
        Entry::Placed { body, .. } => Some(body.clone()),
        _ => None,
    });
    desk.rests();
    let seen = desk.look();
    is_at(&seen, &laid, Vec3::new(-1.5, 1.25, 0.0));
    desk.picture("2-laid");

    // Two that lie about are dragged onto the wall: beside its end, and over the new joint.
    desk.key("2");
    for (from, to, place) in [
        ([0.0, 0.5, 2.0], [0.0, 0.3, 0.1], [0.5, 0.25, 0.0]),
        ([1.5, 0.5, 2.0], [-0.2, 0.5, 0.1], [0.0, 0.75, 0.0]),
    ] {
        desk.drag(seen.on_screen(from.into()), seen.on_screen(to.into()));
        let moved = desk.wait("the brick is put down", |entry| match entry {
            Entry::Moved { body, .. } => Some(body.clone()),
            _ => None,
        });
        desk.rests();
        is_at(&desk.look(), &moved, place.into());
    }
    desk.picture("3-dragged");

    // The stack is pressed near its edge, and stands.
    let before = desk.look();
    desk.key("4");
    let edge = before.on_screen(Vec3::new(3.25, 4.0, 0.0));
    desk.down(edge);
    desk.wait("it is pressed", |entry| {
        matches!(entry, Entry::Pressed { .. }).then_some(())
    });
    sleep(Duration::from_secs(4));
    desk.picture("4-pressed");
    desk.up();
    desk.rests();
    let after = desk.look();
    assert_eq!(moved(&before, &after, THERE), BTreeSet::new());

    // The bodies that would fall are shown before a body is removed.
    desk.key("5");
    let [third, fourth, top] = [2.0, 2.8, 3.6].map(|y| nearest(&after, Vec3::new(3.0, y, 0.0)));
    let middle = after.on_screen(Vec3::new(3.0, 2.0, 0.4));
    desk.point(middle);
    assert_eq!(desk.would_fall(&third), [fourth, top]);
    desk.picture("5-would-fall");
    desk.point(after.on_screen(Vec3::new(-1.5, 1.5, 0.0)));
    assert_eq!(desk.would_fall(&laid), Vec::<String>::new());

    // The top is taken, and taken back.
    desk.click(after.on_screen(Vec3::new(-1.5, 1.5, 0.0)));
    let taken = desk.wait("it is taken", |entry| match entry {
        Entry::Took { bodies } => Some(bodies.clone()),
        _ => None,
    });
    assert_eq!(taken, std::slice::from_ref(&laid));
    assert_eq!(desk.look().bodies.len(), 13);
    desk.picture("6-taken");
    desk.key("ctrl+z");
    desk.wait("it is taken back", |entry| {
        matches!(entry, Entry::Undid).then_some(())
    });
    desk.rests();
    let undone = desk.look();
    assert_eq!(moved(&after, &undone, THERE), BTreeSet::new());
    is_at(&undone, &laid, Vec3::new(-1.5, 1.25, 0.0));
    desk.picture("7-undone");

    // The cube is removed: exactly the bodies fall that were predicted to fall.
    desk.point(middle);
    let falls = desk.would_fall(&third);
    desk.click(middle);
    desk.wait("it is taken", |entry| {
        matches!(entry, Entry::Took { .. }).then_some(())
    });
    desk.rests();
    let fallen = desk.look();
    let mut gone = moved(&undone, &fallen, 0.02);
    gone.remove(&third);
    assert_eq!(gone, falls.into_iter().collect());
    desk.picture("8-fallen");

    // The hand lifts a brick off the ground.
    desk.key("3");
    let lies = fallen.on_screen(Vec3::new(-2.5, 0.5, 2.0));
    desk.down(lies);
    let held = desk.wait("it is held", |entry| match entry {
        Entry::Held { body } => Some(body.clone()),
        _ => None,
    });
    desk.slide(lies, lies - Vec2::Y * 120.0);
    sleep(Duration::from_secs(3));
    let lifted = place(&desk.look(), &held).0.y;
    assert!(lifted > 0.6, "it was lifted to {lifted} m");
    desk.picture("9-lifted");
    desk.up();
    desk.rests();

    // Saved, cleared away with the scene, and loaded.
    let before = desk.look();
    desk.key("ctrl+s");
    let saved = desk.wait("it is saved", |entry| match entry {
        Entry::Saved { pieces } => Some(*pieces),
        _ => None,
    });
    desk.key("BackSpace");
    desk.wait("the scene is opened again", |entry| {
        matches!(entry, Entry::Opened { .. }).then_some(())
    });
    desk.key("ctrl+o");
    let loaded = desk.wait("it is loaded", |entry| match entry {
        Entry::Loaded { pieces } => Some(*pieces),
        _ => None,
    });
    assert_eq!([saved, loaded], [before.bodies.len(); 2]);
    desk.rests();
    let loaded = desk.look();
    for (body, at, _) in &before.bodies {
        let mut distances = loaded
            .bodies
            .iter()
            .map(|(_, there, _)| there.distance(*at));
        assert!(distances.any(|far| far < THERE), "{body} was not loaded");
    }

    // While time stands still, one is laid on the ground and one on that; they are there when it goes on.
    desk.key("space");
    desk.key("1");
    desk.click(loaded.on_screen(Vec3::new(-1.0, 0.0, 3.5)));
    desk.click(loaded.on_screen(Vec3::new(-0.9, 0.5, 3.5)));
    desk.key("space");
    let [lower, upper] = [(); 2].map(|()| {
        desk.wait("a brick is laid", |entry| match entry {
            Entry::Placed { body, at } => Some((body.clone(), *at)),
            _ => None,
        })
    });
    assert_eq!((lower.1.y, upper.1.y), (0.25, 0.75));
    desk.rests();
    let laid = desk.look();
    is_at(&laid, &lower.0, lower.1);
    is_at(&laid, &upper.0, upper.1);

    // The stack is pushed over at its top, and the builder says what gave way.
    desk.key("4");
    let face = loaded.on_screen(Vec3::new(3.0, 2.9, 0.4));
    desk.down(face);
    desk.slide(face, face + Vec2::new(-160.0, -40.0));
    desk.wait("it has lost its hold", |entry| {
        matches!(entry, Entry::Collapsed { .. }).then_some(())
    });
    desk.up();
    desk.picture("10-tipped");
}

fn widget(sight: &Sight, name: &str) -> Vec2 {
    let mut widgets = sight.widgets.iter();
    let found = widgets.find(|(of, _)| of == name);
    found
        .unwrap_or_else(|| panic!("the panel has {name}"))
        .1
        .into()
}

fn place(sight: &Sight, body: &str) -> (Vec3, Quat) {
    let found = sight.bodies.iter().find(|(of, ..)| of == body);
    let (_, at, turn) = found.unwrap_or_else(|| panic!("{body} is there"));
    (*at, *turn)
}

fn nearest(sight: &Sight, there: Vec3) -> String {
    let far = |(_, at, _): &&(String, Vec3, Quat)| at.distance(there);
    let found = sight.bodies.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
    found.expect("there are bodies").0.clone()
}

fn is_at(sight: &Sight, body: &str, there: Vec3) {
    let (at, turn) = place(sight, body);
    let far = at.distance(there);
    println!("{body} is {:.3} mm from where it was put", 1e3 * far);
    assert!(far < THERE, "{body} is at {at} and not at {there}");
    assert!(turn.angle_between(Quat::IDENTITY) < 0.01, "{body}: {turn}");
}

/// The bodies that have moved farther than `far` (m).
fn moved(before: &Sight, after: &Sight, far: f32) -> BTreeSet<String> {
    let there = |body: &str| after.bodies.iter().find(|(of, ..)| of == body);
    let bodies = before.bodies.iter();
    let moved = bodies
        .filter(|(body, at, _)| there(body).is_none_or(|(_, now, _)| now.distance(*at) > far));
    moved.map(|(body, ..)| body.clone()).collect()
}

/// A display with the builder on it, and a simulated user.
struct Desk {
    display: String,
    children: Vec<Child>,
    journal: Receiver<Entry>,
    /// Entries of the journal that were read but not used yet.
    unread: RefCell<VecDeque<Entry>>,
}

impl Drop for Desk {
    fn drop(&mut self) {
        for child in self.children.iter_mut().rev() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

impl Desk {
    fn new() -> Option<Self> {
        for tool in ["Xvfb", "xdotool"] {
            let found = Command::new("which").arg(tool).output();
            if !found.is_ok_and(|found| found.status.success()) {
                println!("not clicked: {tool} is not installed (see examples/builder/README.md)");
                return None;
            }
        }
        let mut xvfb = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x720x24"])
            .args(["+extension", "GLX", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        let answer = xvfb.stdout.take().expect("it is piped");
        BufReader::new(answer)
            .read_line(&mut number)
            .expect("it says its number");
        let display = format!(":{}", number.trim());
        fs::create_dir_all(folder()).expect("pictures can be written");
        let mut builder = Command::new(env!("CARGO_BIN_EXE_drystone-builder"))
            .args(["--journal", "--scene", "yard", "--size", "960x540"])
            .arg("--file")
            .arg(folder().join("clicks.ron"))
            .current_dir(ROOT)
            .env("DISPLAY", &display)
            .env("WGPU_BACKEND", "vulkan")
            .stdout(Stdio::piped())
            .spawn()
            .expect("the builder starts");
        let output = builder.stdout.take().expect("it is piped");
        let (sender, journal) = channel();
        spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                match line.strip_prefix("journal ") {
                    Some(entry) => {
                        let entry = ron::from_str(entry).expect("the journal can be read");
                        let _ = sender.send(entry);
                    }
                    None => println!("builder: {line}"),
                }
            }
        });
        let desk = Self {
            display,
            children: vec![xvfb, builder],
            journal,
            unread: RefCell::default(),
        };
        desk.wait("the scene is open", |entry| {
            matches!(entry, Entry::Opened { .. }).then_some(())
        });
        let window = desk.xdotool(&["search", "--sync", "--name", "drystone builder"]);
        desk.xdotool(&["windowfocus", "--sync", window.trim()]);
        desk.rests();
        Some(desk)
    }

    fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool")
            .args(arguments)
            .env("DISPLAY", &self.display)
            .output()
            .expect("xdotool runs");
        assert!(output.status.success(), "xdotool {arguments:?} fails");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }

    fn point(&self, at: Vec2) {
        let [x, y] = [at.x, at.y].map(|at| at.round().to_string());
        self.xdotool(&["mousemove", &x, &y]);
        self.seen();
    }

    fn down(&self, at: Vec2) {
        self.point(at);
        self.xdotool(&["mousedown", "1"]);
        self.seen();
    }

    fn up(&self) {
        self.xdotool(&["mouseup", "1"]);
        self.seen();
    }

    fn slide(&self, from: Vec2, to: Vec2) {
        for i in 1..=4 {
            self.point(from.lerp(to, i as f32 / 4.0));
        }
    }

    fn click(&self, at: Vec2) {
        self.down(at);
        self.up();
    }

    fn drag(&self, from: Vec2, to: Vec2) {
        self.down(from);
        self.slide(from, to);
        self.up();
    }

    fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
        self.seen();
    }

    /// Waits for the frame in which all that was done so far is seen: two clicks in one frame are none. A look answers in it.
    fn seen(&self) -> Sight {
        self.xdotool(&["key", "l"]);
        let patience = Duration::from_secs(PATIENCE);
        loop {
            match self.journal.recv_timeout(patience) {
                Ok(Entry::Sees(sight)) => return *sight,
                Ok(other) => self.unread.borrow_mut().push_back(other),
                Err(_) => panic!("the builder does not answer"),
            }
        }
    }

    /// Waits for an entry of the journal from which a value can be taken, and returns the value.
    fn wait<T>(&self, what: &str, says: impl Fn(&Entry) -> Option<T>) -> T {
        let until = Instant::now() + Duration::from_secs(PATIENCE);
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let unread = self.unread.borrow_mut().pop_front();
            let entry = unread.or_else(|| self.journal.recv_timeout(left).ok());
            if let Some(Entry::Collapsed { first, how }) = &entry {
                println!("(collapse: {first} {how})");
            }
            let entry = entry.unwrap_or_else(|| panic!("{what}: nothing of it in the journal"));
            if let Some(found) = says(&entry) {
                println!("{what}");
                return found;
            }
            if let Entry::Refused { why } = &entry {
                panic!("{what}: {why}");
            }
        }
    }

    /// Waits until all bodies have been at rest for a while, because a released body has not begun to fall at once.
    fn rests(&self) {
        let until = Instant::now() + Duration::from_secs(PATIENCE);
        let mut still = 0;
        while still < 4 {
            sleep(Duration::from_millis(250));
            still = if self.look().rests { still + 1 } else { 0 };
            assert!(Instant::now() < until, "it does not come to rest");
        }
    }

    fn look(&self) -> Sight {
        self.seen()
    }

    fn would_fall(&self, without: &str) -> Vec<String> {
        self.wait("what would fall is known", |entry| match entry {
            Entry::WouldFall { body, falls } if body == without => Some(falls.clone()),
            _ => None,
        })
    }

    fn picture(&self, name: &str) {
        self.key("F12");
        let path = self.wait("a picture", |entry| match entry {
            Entry::Picture { path } => Some(Path::new(ROOT).join(path)),
            _ => None,
        });
        let until = Instant::now() + Duration::from_secs(PATIENCE);
        while !path.exists() {
            assert!(Instant::now() < until, "{} did not come", path.display());
            sleep(Duration::from_millis(100));
        }
        // It is written all at once, but by another thread.
        sleep(Duration::from_millis(500));
        fs::rename(&path, folder().join(format!("{name}.png"))).expect("it is there");
    }
}

fn folder() -> PathBuf {
    Path::new(ROOT).join("target/builder")
}
