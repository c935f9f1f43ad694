//! A server needs no window, no renderer and no loudspeaker: what drystone depends on has none of them.

use std::process::Command;

/// Prefixes of the names of crates that draw, play sounds or open windows.
const NEVER: [&str; 16] = [
    "bevy ",
    "bevy_internal",
    "bevy_render",
    "bevy_pbr",
    "bevy_core_pipeline",
    "bevy_sprite",
    "bevy_winit",
    "bevy_window",
    "bevy_audio",
    "bevy_ui",
    "wgpu",
    "winit",
    "cpal",
    "rodio",
    "ash",
    "x11",
];

fn tree(features: &str) -> String {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--package", "drystone", "--edges", "normal"])
        .args(["--prefix", "none", "--locked", "--features", features])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo is there, it runs this test");
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).expect("names of packages")
}

#[test]
fn nothing_draws_or_sounds_on_a_server() {
    for features in ["", "diagnostics", "stability", "diagnostics,stability"] {
        let tree = tree(features);
        let packages: Vec<&str> = tree.lines().collect();
        assert!(packages.iter().any(|line| line.starts_with("bevy_ecs ")));
        for never in NEVER {
            let found = packages.iter().find(|line| line.starts_with(never));
            assert_eq!(found, None, "with features {features:?}");
        }
    }
}
