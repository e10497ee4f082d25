//! Whatever is wrong is refused, with the place and the remedy; nothing panics.

use ishigaki::WorldOptions;
use ishigaki_scenes::named::Random;
use ishigaki_scenes::{SceneFile, named, set_option};

/// A scene with one body of one shape, `inner` being the fields of the shape.
fn shape(inner: &str) -> String {
    format!(r#"{{"bodies": [{{"name": "brick", "shapes": [{{{inner}}}]}}]}}"#)
}

/// A scene with one ball-shaped body that has the fields `inner`.
fn body(inner: &str) -> String {
    format!(r#"{{"bodies": [{{"shapes": [{{"geometry": {{"ball": {{"radius": 1}}}}}}], {inner}}}]}}"#)
}

/// Three balls, two of one name, and a joint with the fields `inner`.
fn joint(inner: &str) -> String {
    let ball = r#""shapes": [{"geometry": {"ball": {"radius": 1}}}]"#;
    format!(
        r#"{{"bodies": [{{"name": "door", {ball}}}, {{"name": "twin", {ball}}}, {{"name": "twin", {ball}}}],
            "joints": [{{"name": "j", {inner}}}]}}"#
    )
}

fn refused(json: &str) -> String {
    match SceneFile::from_json(json, "bad.json").and_then(|file| file.build()) {
        Ok(_) => panic!("accepted: {json}"),
        Err(error) => error.to_string(),
    }
}

/// Each message must contain all the parts.
fn check(cases: Vec<(String, &[&str])>) {
    for (json, parts) in cases {
        let message = refused(&json);
        if message.contains("number out of range") {
            // A parser that rounds to 32 bits itself (another crate of the build may ask for it) refuses earlier.
            assert!(message.starts_with("bad.json:"), "{message}");
            continue;
        }
        for part in parts {
            assert!(message.contains(part), "{json}\n  says: {message}\n  lacks: {part}");
        }
    }
}

#[test]
fn text_that_is_no_scene() {
    check(vec![
        ("".into(), &["bad.json:1:0: EOF while parsing a value"]),
        ("{".into(), &["bad.json:1:1: EOF while parsing an object"]),
        ("{}{}".into(), &["bad.json:1:3: trailing characters"]),
        ("[]".into(), &["bad.json: a scene is an object { … }, not a list"]),
        ("17".into(), &["bad.json:1:2: invalid type: integer `17`"]),
        (r#"{"version": 2}"#.into(), &["bad.json: version: this program reads version 1, the file has version 2"]),
        (
            r#"{"bodys": []}"#.into(),
            &["bad.json:1:8: ", "unknown field `bodys`, did you mean `bodies`? Expected one of"],
        ),
        (r#"{"xyzzy": []}"#.into(), &["unknown field `xyzzy`, expected one of `version`, `name`"]),
        (r#"{"dt": "fast"}"#.into(), &["bad.json:1:13: dt: invalid type: string \"fast\", expected f32"]),
        (r#"{"dt": 1e999}"#.into(), &["bad.json:1:12: dt: number out of range"]),
        (r#"{"dt": NaN}"#.into(), &["bad.json:1:8: dt: expected value"]),
        (
            r#"{"bodies": [{"shapes": [{"geometry": {}}]}]}"#.into(),
            &["bodies[0].shapes[0].geometry: expected value: ", "say its name, as in {\"ball\": {\"radius\": 1}}"],
        ),
        (r#"{"steps": -1}"#.into(), &["steps: invalid value: integer `-1`, expected u32"]),
        (r#"{"steps": 1.5}"#.into(), &["steps: invalid type: floating point `1.5`, expected u32"]),
        (r#"{"steps": 1, "steps": 2}"#.into(), &["duplicate field `steps`"]),
        (r#"{"options": {"solver": {"slop": {"dept": 1}}}}"#.into(), &["options.solver.slop", "did you mean `depth`?"]),
        (
            r#"{"options": {"solver": {"permutation": "per_sweeep"}}}"#.into(),
            &["options.solver.permutation", "unknown variant `per_sweeep`, did you mean `per_sweep`?"],
        ),
    ]);
}

#[test]
fn shapes_that_make_no_sense() {
    let hull = |points: &str| shape(&format!(r#""geometry": {{"convex_hull": {{"points": {points}}}}}"#));
    check(vec![
        (shape(""), &["bodies[0].shapes[0]: missing field `geometry`"]),
        (
            shape(r#""geometry": {"ball": {"radius": 1}}, "frictoin": 1"#),
            &["bad.json:1:", "bodies[0].shapes[0]", "unknown field `frictoin`, did you mean `friction`?"],
        ),
        (shape(r#""geometry": {"bal": {"radius": 1}}"#), &["geometry", "unknown variant `bal`, did you mean `ball`?"]),
        (shape(r#""geometry": {"ball": {}}"#), &["bodies[0].shapes[0].geometry.ball: missing field `radius`"]),
        (
            shape(r#""geometry": {"ball": {"radius": 0}}"#),
            &["bodies[0] \"brick\": shapes[0].radius: must be finite and > 0, is 0"],
        ),
        (shape(r#""geometry": {"ball": {"radius": -1}}"#), &["shapes[0].radius: must be finite and > 0, is -1"]),
        (shape(r#""geometry": {"ball": {"radius": 1e39}}"#), &["shapes[0].radius: must be finite"]),
        (shape(r#""geometry": {"cuboid": {"half_extents": [1, 2]}}"#), &["half_extents: invalid length 2"]),
        (shape(r#""geometry": {"cuboid": {"half_extents": [1, 2, 3, 4]}}"#), &["half_extents"]),
        (
            shape(r#""geometry": {"cuboid": {"half_extents": [1, 0, 1]}}"#),
            &["shapes[0].half_extents[1]: must be finite"],
        ),
        (
            shape(r#""geometry": {"capsule": {"half_length": -1, "radius": 1}}"#),
            &["shapes[0].half_length: must be in [0,"],
        ),
        (
            shape(r#""geometry": {"half_space": {}}"#),
            &["bodies[0] \"brick\": shapes[0]: a half-space", "cannot be dynamic"],
        ),
        (hull("[[0,0,0]]"), &["shapes[0].points: a hull needs at least 4 points, has 1"]),
        (hull("[[0,0,0],[1,0,0],[0,1,0],[1,1,0]]"), &["shapes[0]", "must span a volume"]),
        (hull("[[0,0,0],[0,0,0],[0,0,0],[0,0,0]]"), &["shapes[0]", "must span a volume"]),
        (hull("[[0,0,0],[1,0,0],[0,1,0],[0,0,1e39]]"), &["shapes[0].points[3]: must be finite"]),
        (
            shape(r#""geometry": {"triangle_mesh": {"vertices": [[0,0,0]], "triangles": [[0,0,7]]}}"#),
            &["shapes[0].triangles[0]: vertex 7 does not exist: there are 1"],
        ),
        (shape(r#""geometry": {"triangle_mesh": {"vertices": [], "triangles": []}}"#), &["at least one triangle"]),
        (
            shape(
                r#""geometry": {"height_field": {"rows": 3, "columns": 2, "heights": [0], "size_x": 1, "size_z": 1}}"#,
            ),
            &["shapes[0].heights: 3 rows × 2 columns do not match 1 heights"],
        ),
        (
            shape(
                r#""geometry": {"height_field": {"rows": 18446744073709551615, "columns": 2, "heights": [0], "size_x": 1, "size_z": 1}}"#,
            ),
            &["shapes[0].heights", "do not match"],
        ),
        (
            shape(r#""geometry": {"shared_hull": "stone"}"#),
            &["shapes[0].shared_hull: unknown hull `stone`; there are none"],
        ),
        (
            r#"{"hulls": {"stone": {"points": []}}}"#.into(),
            &["hulls.stone: points: a hull needs at least 4 points, has 0"],
        ),
        (
            r#"{"meshes": {"roof": {"vertices": [[0,0,0],[1,0,0],[0,1,0]], "triangles": [[0,1,2]]}},
                "bodies": [{"kind": "fixed", "shapes": [{"geometry": {"shared_mesh": "rof"}}]}]}"#
                .into(),
            &["bodies[0]: shapes[0].shared_mesh: unknown mesh `rof`; did you mean `roof`?"],
        ),
        (
            shape(r#""geometry": {"compound": {"shapes": []}}"#),
            &["shapes[0].shapes: a compound needs at least one shape"],
        ),
        (
            shape(r#""geometry": {"ball": {"radius": 1}}, "restitution": 2"#),
            &["shapes[0].restitution: must be in [0, 1], is 2"],
        ),
        (
            shape(r#""geometry": {"ball": {"radius": 1}}, "rotation": [0,0,0,0]"#),
            &["shapes[0].rotation: must be a unit quaternion"],
        ),
        (
            shape(r#""geometry": {"ball": {"radius": 1}}, "density": -1"#),
            &["shapes[0].density: must be finite and ≥ 0"],
        ),
    ]);
}

#[test]
fn compounds_without_end() {
    let nested = |depth: usize| {
        let mut geometry = r#"{"ball": {"radius": 1}}"#.to_string();
        for _ in 0..depth {
            geometry = format!(r#"{{"compound": {{"shapes": [{{"geometry": {geometry}}}]}}}}"#);
        }
        shape(&format!(r#""geometry": {geometry}"#))
    };
    check(vec![
        (nested(20), &["compounds are nested deeper than 16: lay them out flat"]),
        (nested(10_000), &["recursion limit exceeded", "lay them out flat"]),
        (r#"{"bodies":"#.to_string() + &"[".repeat(1_000_000), &["bad.json:1:"]),
    ]);
}

#[test]
fn bodies_that_make_no_sense() {
    check(vec![
        (
            body(r#""kind": "static""#),
            &["bodies[0].kind: unknown variant `static`, expected one of `fixed`, `kinematic`"],
        ),
        (body(r#""position": [0, 1e39, 0]"#), &["bodies[0]: position: must be finite"]),
        (body(r#""position": [0, 1e9, 0]"#), &["bodies[0]: position: must be within"]),
        (body(r#""rotation": [0, 0, 1]"#), &["bodies[0].rotation: invalid length 3"]),
        (body(r#""rotation": [0, 0, 1, 1]"#), &["bodies[0]: rotation: must be a unit quaternion, has length 1.41421"]),
        (body(r#""mass": {"total": 0}"#), &["bodies[0]: mass: must be finite and > 0, is 0"]),
        (body(r#""mass": {"density": -2}"#), &["bodies[0]: shapes[0].density: must be finite and ≥ 0, is -2"]),
        (body(r#""mass": 3"#), &["bodies[0].mass: "]),
        (
            body(r#""mass": {"properties": {"mass": 1, "principal_inertia": [1, 1, 9]}}"#),
            &["bodies[0]: mass_properties.principal_inertia: no body has the moments (1, 1, 9)"],
        ),
        (body(r#""linear_damping": -1"#), &["bodies[0]: linear_damping: must be finite and ≥ 0"]),
        (body(r#""force_threshold": -1"#), &["bodies[0]: force_threshold: must be finite and ≥ 0, is -1"]),
        (r#"{"dt": 0}"#.into(), &["dt: must be finite and > 0, is 0"]),
        (r#"{"options": {"length_scale": 0}}"#.into(), &["options.length_scale: must be finite and > 0, is 0"]),
        (
            r#"{"options": {"solver": {"weight_amplification": {"factor": 0.5}}}}"#.into(),
            &["options.solver.weight_amplification.factor: must be finite and ≥ 1"],
        ),
    ]);
}

#[test]
fn joints_that_make_no_sense() {
    let between = |a: &str, b: &str| {
        joint(&format!(r#""body_a": {a}, "body_b": {b}, "kind": "fixed", "frame": {{"world": {{}}}}"#))
    };
    let kind = |k: &str| joint(&format!(r#""body_a": 0, "body_b": 1, "kind": {k}, "frame": {{"world": {{}}}}"#));
    let frame = |f: &str| joint(&format!(r#""body_a": 0, "body_b": 1, "kind": "fixed", "frame": {f}"#));
    check(vec![
        (joint(r#""body_a": 0"#), &["joints[0]: missing field `body_b`"]),
        (between("0", "0"), &["joints[0] \"j\": body_b: must differ from body_a"]),
        (between("0", "3"), &["joints[0] \"j\": body_b: there is no body 3: the scene has 3 bodies, counted from 0"]),
        (between("-1", "0"), &["joints[0].body_a: invalid type: integer `-1`, expected a body's name or its index"]),
        (between("[]", "0"), &["joints[0].body_a: ", "expected a body's name or its index in `bodies`, from 0"]),
        (between("\"dor\"", "0"), &["joints[0] \"j\": body_a: unknown body `dor`; did you mean `door`?"]),
        (between("\"moon\"", "0"), &["unknown body `moon`; there are: door, twin"]),
        (
            between("\"twin\"", "0"),
            &["body_a: the name `twin` is shared by bodies[1] and bodies[2]: rename one or refer by index"],
        ),
        (kind("\"hinje\""), &["joints[0].kind: unknown variant `hinje`, did you mean `hinge`?"]),
        (
            kind(r#"{"hinge": {"limits": {}}}"#),
            &["joints[0].kind.hinge", "unknown field `limits`, did you mean `limit`?"],
        ),
        (
            kind(r#"{"hinge": {"limit": {"lower": -3.5e38}}}"#),
            &["joints[0].kind.hinge.limit.lower", "must be finite and fit 32 bits: leave it out for no bound"],
        ),
        (kind(r#"{"hinge": {"limit": {"lower": 1, "upper": 0}}}"#), &["joints[0] \"j\": limit: ends are exchanged"]),
        (
            kind(r#"{"slider": {"spring": {"stiffness": -1}}}"#),
            &["joints[0] \"j\": spring.stiffness: must be finite and ≥ 0"],
        ),
        (kind(r#"{"ball": {"cone": 4}}"#), &["joints[0] \"j\": cone: must be in [0, π] rad, is 4"]),
        (kind(r#"{"distance": {"lower": -1}}"#), &["joints[0] \"j\": range: a distance is ≥ 0"]),
        (
            kind(r#"{"generic": {"angular": [{"axis": [1,0,0]}, {"axis": [1,0,0]}]}}"#),
            &["joints[0] \"j\": angular: the axes must be independent"],
        ),
        (kind(r#"{"generic": {"linear": ["locked"]}}"#), &["joints[0].kind.generic.linear: invalid length 1"]),
        (frame(r#"{"world": {"axis": [0,0,0]}}"#), &["joints[0] \"j\": frame.axis: must be finite and not zero"]),
        (
            frame(r#"{"local": {"b": {"axis": [1,0,0], "rotation": [0,0,0,1]}}}"#),
            &["joints[0] \"j\": frame_b: has both `rotation` and `axis`: say one of them"],
        ),
        (frame(r#"{"world": {"position": [0,0,1e39]}}"#), &["joints[0] \"j\": frame.position: must be finite"]),
        (
            between("0", "1").replace("\"joints\"", "\"excluded_pairs\": [[0, 0]], \"joints\""),
            &["excluded_pairs[0]: names one body twice"],
        ),
        (
            between("0", "1").replace("\"joints\"", "\"excluded_pairs\": [[0, 9]], \"joints\""),
            &["excluded_pairs[0][1]: there is no body 9"],
        ),
    ]);
}

#[test]
fn scenes_and_parameters_that_do_not_exist() {
    let ask = |name: &str, parameters: &[(&str, f64)]| {
        let parameters: Vec<(String, f64)> = parameters.iter().map(|(n, v)| (n.to_string(), *v)).collect();
        named(name, &parameters).unwrap_err().to_string()
    };
    assert!(
        ask("towr", &[]).starts_with("scene: unknown scene `towr`; did you mean `tower`? there are: tower, wall, ")
    );
    assert!(ask("moon", &[]).starts_with("scene: unknown scene `moon`; there are: tower, wall, "));
    assert_eq!(
        ask("pyramid", &[("bas", 3.0)]),
        "pyramid: unknown parameter `bas`; did you mean `base`? there are: base"
    );
    assert_eq!(ask("dzhanibekov", &[("n", 3.0)]), "dzhanibekov: unknown parameter `n`; there are none");
    assert_eq!(ask("tower", &[("n", 0.0)]), "tower.n: must be in [1, 10000], is 0");
    assert_eq!(ask("tower", &[("n", 2.5)]), "tower.n: must be a whole number, is 2.5");
    assert_eq!(ask("tower", &[("n", f64::NAN)]), "tower.n: must be a whole number, is NaN");
    assert_eq!(ask("tower", &[("n", 1e300)]), "tower.n: must be in [1, 10000], is 1e300");
    assert_eq!(ask("tower", &[("n", 3.0), ("n", 3.0)]), "tower.n: is given twice");
    assert_eq!(ask("sliding_block", &[("angle", 90.0)]), "sliding_block.angle: must be in [0, 80] °, is 90");
    assert_eq!(ask("sliding_block", &[("friction", f64::NAN)]), "sliding_block.friction: must be in [0, 10], is NaN");
}

#[test]
fn options_that_do_not_exist() {
    let ask = |path: &str, value: &str| {
        let mut options = WorldOptions::default();
        let error = set_option(&mut options, path, value).expect_err(path).to_string();
        assert_eq!(options, WorldOptions::default(), "{path}={value} was refused and yet changed something");
        error
    };
    for (path, value, expected) in [
        (
            "solver.weight_amplificaton.factor",
            "2",
            "solver: unknown option `weight_amplificaton`; did you mean `weight_amplification`?",
        ),
        (
            "solver.slop.dept",
            "2",
            "solver.slop: unknown option `dept`; did you mean `depth`? there are: depth, enabled",
        ),
        ("solvr.slop.depth", "2", "options: unknown option `solvr`; did you mean `solver`?"),
        ("", "2", "options: unknown option ``; there are: contact, gravity"),
        ("solver.slop.depth.x", "2", "solver.slop.depth.x: `solver.slop.depth` is an option, not a group"),
        ("solver.slop.depth", "deep", "solver.slop.depth: expects a number, got `deep`"),
        ("solver.slop.depth", "1e39", "solver.slop.depth: expects a number, got `1e39`"),
        ("solver.slop.depth", "NaN", "solver.slop.depth: expects a number, got `NaN`"),
        ("solver.slop.depth", "-1", "solver.slop.depth: must be finite and ≥ 0, is -1"),
        ("solver.slop.enabled", "maybe", "solver.slop.enabled: expects true or false, got `maybe`"),
        ("solver.sweeps", "2.5", "solver.sweeps: expects a whole number ≥ 0, got `2.5`"),
        ("solver.sweeps", "-2", "solver.sweeps: expects a whole number ≥ 0, got `-2`"),
        ("solver.sweeps", "5000000000", "solver.sweeps: invalid value: integer `5000000000`, expected u32"),
        ("solver.substeps", "0", "solver.substeps: must be in [1, 1000], is 0"),
        (
            "solver.permutation",
            "per_sweeep",
            "solver.permutation: unknown variant `per_sweeep`, did you mean `per_sweep`?",
        ),
        ("solver.weight_amplification.factor", "0.5", "solver.weight_amplification.factor: must be finite and ≥ 1"),
        ("solver", "tlak", "solver: unknown preset `tlak`; did you mean `talk`? there are: plain, talk, default"),
        (
            "solver.slop",
            "deep",
            "solver.slop: takes on or off, or one of its options is set, as in `solver.slop.depth=…`",
        ),
        ("rest", "on", "rest: is a group of options: set one of them, as in `rest.aggressive_sleep=…`"),
        ("solver.slop", "{\"dept\": 1}", "solver.slop: unknown option `dept`; did you mean `depth`?"),
        ("gravity", "down", "gravity: expects a list, as in [0, -9.81, 0], got `down`"),
        ("gravity", "[0, 1]", "gravity: invalid length 2"),
    ] {
        let message = ask(path, value);
        assert!(message.starts_with(expected), "{path}={value}\n  says:     {message}\n  expected: {expected}");
    }
}

/// Broken copies of a scene with everything in it: numbers made evil, bytes lost, pieces doubled. Whatever comes of it
/// is a scene or an error.
#[test]
fn broken_files_never_panic() {
    const EVIL: [&str; 12] =
        ["0", "-1", "1e38", "-1e38", "1e-45", "1e999", "0.5", "3", "4294967295", "18446744073709551616", "null", "[]"];
    let whole = include_str!("data/everything.json");
    let mut random = Random::new(5);
    let mut built = 0;
    for _ in 0..1500 {
        let mut text = whole.to_string();
        for _ in 0..1 + random.next_u64() % 3 {
            let at = random.next_u64() as usize % text.len();
            let Some(start) = text[..]
                .char_indices()
                .map(|(i, _)| i)
                .filter(|&i| i >= at)
                .find(|&i| text.as_bytes()[i].is_ascii_digit() && !text.as_bytes()[i - 1].is_ascii_digit())
            else {
                continue;
            };
            let end = start + text[start..].find([',', ']', '}', ' ', '"']).unwrap_or(0);
            match random.next_u64() % 8 {
                0 => drop(text.drain(start..end)),
                1 => text.insert_str(start, "\"x\": 1, "),
                _ => text.replace_range(start..end, EVIL[random.next_u64() as usize % EVIL.len()]),
            }
        }
        if let Ok(file) = SceneFile::from_json(&text, "broken") {
            let again = SceneFile::from_json(&file.to_json(), "again");
            if let Ok(mut scene) = file.build() {
                // What the engine takes, it can say again and it can step.
                assert_eq!(again.unwrap(), file);
                scene.world.step(scene.dt);
                built += 1;
            }
        }
    }
    assert!(built > 200, "only {built} of the broken scenes could be built: the test tests little");
}
