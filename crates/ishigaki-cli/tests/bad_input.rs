//! Input that is wrong ends with exit code 2 and a message that names the place; no file is left behind.

mod common;

use common::{Folder, stderr};

/// Runs a line of arguments; the message must hold all of `words`.
fn refused(folder: &Folder, line: &str, words: &[&str]) {
    let before = folder.files();
    let output = folder.run(&line.split(' ').collect::<Vec<_>>());
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "`{line}` ended with {}\n{message}", output.status);
    assert!(message.contains("error:"), "`{line}`: {message}");
    for word in words {
        assert!(message.contains(word), "`{line}`: no {word:?} in: {message}");
    }
    assert!(!message.contains("panicked"), "`{line}`: {message}");
    assert!(output.stdout.is_empty(), "`{line}` wrote to stdout");
    assert_eq!(folder.files(), before, "`{line}` left files behind");
}

#[test]
fn numbers_that_make_no_sense() {
    let folder = Folder::with_small("bad_numbers");
    for steps in ["0", "-1", "1.5", "ten", "99999999999999999999", "1000000001"] {
        refused(&folder, &format!("run small.json --steps {steps}"), &["--steps", "whole number from 1"]);
    }
    for dt in ["0", "-0.01", "NaN", "inf", "1e9", "1e-60", "fast"] {
        refused(&folder, &format!("run small.json --dt {dt}"), &["--dt", "number of seconds"]);
    }
    refused(&folder, "run small.json --states out.csv --every 0", &["--every", "whole number from 1"]);
    refused(&folder, "run small.json --every 5", &["--states"]);
}

#[test]
fn scenes_that_are_not_there() {
    let folder = Folder::with_small("bad_scenes");
    folder.write("folder.json.keep", "");
    std::fs::create_dir(folder.path().join("folder.json")).unwrap();
    refused(&folder, "run", &["<SCENE"]);
    refused(&folder, "run wal", &["wal", "did you mean `wall`"]);
    refused(&folder, "run no_such_scene_at_all", &["no_such_scene_at_all", "there are"]);
    refused(&folder, "run picture.png", &["picture.png: names of files end in .json, .xml, .mjcf or .urdf"]);
    refused(&folder, "run missing.json", &["missing.json", "No such file", "ishigaki scenes"]);
    refused(&folder, "run missing.urdf", &["missing.urdf", "No such file"]);
    refused(&folder, "run folder.json", &["folder.json", "is a directory"]);
    refused(&folder, "scenes wal", &["wal", "did you mean `wall`"]);
    refused(&folder, "run wall --param no_such_parameter=3", &["no_such_parameter"]);
    refused(&folder, "run wall --param height", &["key=number"]);
    refused(&folder, "run wall --param =3", &["key=number"]);
    refused(&folder, "run wall --param rows=many", &["key=number"]);
    refused(&folder, "run wall --param rows=-3", &["wall.rows", "must be in"]);
    refused(&folder, "run wall --param rows=NaN", &["wall.rows", "must be"]);
    refused(&folder, "run wall --param rows=2.5", &["wall.rows", "whole number"]);
    refused(&folder, "run small.json --param n=3", &["small.json", "--param"]);
    refused(&folder, "run wall --ground", &["wall", "--ground"]);
    refused(&folder, "scenes --param n=3", &["NAME"]);
}

#[test]
fn files_that_are_wrong() {
    let folder = Folder::new("bad_files");
    let ball = |more: &str| format!(r#"{{ "bodies": [{{ {more} }}] }}"#);
    folder.write("empty.json", "");
    folder.write("broken.json", "{\n  \"bodies\": [\n    { \"name\": \"a\", }\n  ]\n}");
    folder.write("unknown.json", "{\n  \"bodeis\": []\n}");
    folder.write("type.json", "{\n  \"dt\": \"fast\"\n}");
    folder.write("binary.json", [0xff, 0xfe, 0x00, 0x80]);
    folder.write("version.json", r#"{ "version": 99 }"#);
    folder.write("dt.json", r#"{ "dt": -1 }"#);
    folder.write("radius.json", ball(r#""shapes": [{ "geometry": { "ball": { "radius": -1 } } }]"#));
    folder.write("option.json", r#"{ "options": { "length_scale": 0 } }"#);
    folder.write(
        "joint.json",
        r#"{ "joints": [{ "body_a": "nobody", "body_b": "none", "kind": "fixed", "frame": { "world": {} } }] }"#,
    );
    folder.write("broken.xml", "<mujoco><worldbody>");
    folder.write("broken.urdf", "<robot");
    refused(&folder, "run empty.json", &["empty.json:1:", "EOF"]);
    refused(&folder, "run broken.json", &["broken.json:3:20"]);
    refused(&folder, "run unknown.json", &["unknown.json:2:", "bodeis", "did you mean `bodies`"]);
    refused(&folder, "run type.json", &["type.json:2:", "dt"]);
    refused(&folder, "run binary.json", &["binary.json", "UTF-8"]);
    refused(&folder, "run version.json", &["version.json", "99"]);
    refused(&folder, "run dt.json", &["dt.json", "dt", "-1"]);
    refused(&folder, "run radius.json", &["radius.json", "bodies[0]", "radius", "-1"]);
    refused(&folder, "run option.json", &["option.json", "length_scale"]);
    refused(&folder, "run joint.json", &["joint.json", "nobody"]);
    refused(&folder, "run broken.xml", &["broken.xml"]);
    refused(&folder, "run broken.urdf", &["broken.urdf"]);
}

#[test]
fn options_that_are_not_there() {
    let folder = Folder::with_small("bad_options");
    refused(&folder, "run small.json --set solver.swepes=3", &["solver", "swepes", "did you mean `sweeps`"]);
    refused(&folder, "run small.json --set solver.sweeps=many", &["solver.sweeps", "many"]);
    refused(&folder, "run small.json --set solver.sweeps=-3", &["solver.sweeps"]);
    refused(&folder, "run small.json --set solver.weight_amplification.factor=0.5", &["factor", "≥ 1"]);
    refused(&folder, "run small.json --set length_scale=NaN", &["length_scale"]);
    refused(&folder, "run small.json --set solver.permutation=sorted", &["permutation", "sorted"]);
    refused(&folder, "run small.json --set solver.sweeps", &["path=value"]);
}

#[test]
fn snapshots_that_are_none() {
    let folder = Folder::with_small("bad_snapshots");
    folder.ok(&["run", "small.json", "--quiet", "--steps", "2", "--snapshot", "good.snap"]);
    let good = std::fs::read(folder.path().join("good.snap")).unwrap();
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 0x10;
    folder.write("flipped.snap", &flipped);
    folder.write("short.snap", &good[..good.len() / 2]);
    folder.write("tiny.snap", &good[..3.min(good.len())]);
    folder.write("empty.snap", "");
    folder.write("long.snap", [good.as_slice(), b"more"].concat());
    let mut version = good.clone();
    version[8] += 1;
    folder.write("version.snap", &version);
    folder.write("garbage.snap", "this is no snapshot, but it is long enough to hold a header and a checksum");
    let words: [(&str, &[&str]); 8] = [
        ("flipped", &["damaged"]),
        ("version", &["version"]),
        ("short", &["cut off"]),
        ("tiny", &["not a snapshot"]),
        ("empty", &["not a snapshot"]),
        ("long", &["damaged"]),
        ("garbage", &["not a snapshot"]),
        ("missing", &["No such file"]),
    ];
    for (name, words) in words {
        let file = format!("{name}.snap");
        refused(&folder, &format!("run --from {file} --snapshot out.snap"), &[&[file.as_str()], words].concat());
    }
    refused(&folder, "run wall --from good.snap", &["good.snap", "no snapshot of wall"]);
    refused(&folder, "run --from good.snap --param n=3", &["--param"]);
    refused(&folder, "run --from good.snap --set solver.sweeps=-1", &["solver.sweeps"]);
}

#[test]
fn outputs_that_cannot_be_written() {
    let folder = Folder::with_small("bad_outputs");
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    refused(&folder, "run small.json --states nowhere/out.csv", &["nowhere/out.csv", "cannot be written"]);
    refused(&folder, "run small.json --snapshot nowhere/out.snap", &["nowhere/out.snap", "cannot be written"]);
    refused(&folder, "run small.json --states folder", &["folder", "is a directory"]);
    refused(&folder, "run small.json --states small.json/out.csv", &["small.json/out.csv"]);
    refused(&folder, "run small.json --states out --snapshot out", &["same file"]);
    refused(&folder, "run small.json --states out.csv --snapshot nowhere/out.snap", &["nowhere/out.snap"]);
}

#[test]
fn arguments_that_do_not_exist() {
    let folder = Folder::with_small("bad_arguments");
    refused(&folder, "rn small.json", &["rn"]);
    refused(&folder, "run small.json --step 3", &["--step"]);
    refused(&folder, "run small.json another.json", &["another.json"]);
    refused(&folder, "scenes wall --schema", &["--schema"]);
}
