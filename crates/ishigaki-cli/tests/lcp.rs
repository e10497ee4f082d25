//! `ishigaki lcp` and `run --export-lcp`: files, methods, and what is refused.

mod common;

use common::{Folder, stderr};
use serde_json::{Value, json};

/// Two boxes on each other, and what carries them.
const STACK: &str = r#"{ "a": [[1, -1], [-1, 2]], "b": [-1, 0], "lower": [0, 0], "upper": [null, null] }"#;

/// A block that is pushed along the diagonal of its friction, on a disk and on a box.
fn pushed(disk: bool) -> String {
    let disk = if disk { json!([null, 2, 1]) } else { json!([null, null, null]) };
    json!({
        "a": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "b": [-1, 0.42, 0.42], "lower": [0, null, null],
        "upper": [null, null, null], "mu_of": [null, 0, [0]], "mu": [null, 0.5, 0.5], "disk": disk,
    })
    .to_string()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn near(value: &Value, expected: &[f64], tolerance: f64) -> bool {
    let values = numbers(value);
    values.len() == expected.len() && values.iter().zip(expected).all(|(a, b)| (a - b).abs() < tolerance)
}

#[test]
fn every_method_solves_a_stack() {
    let folder = Folder::new("lcp_methods");
    folder.write("stack.json", STACK);
    for method in ["lemke", "jacobi", "gauss-seidel", "projected-jacobi", "pgs", "nncg", "block-pgs", "dantzig"] {
        let text = folder.ok(&["lcp", "stack.json", "--method", method, "--trace", "trace.csv"]);
        assert_eq!(text.trim_end().lines().count(), 1);
        let result: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(result["status"], "solved", "{method}");
        assert!(near(&result["lambda"], &[2.0, 1.0], 1e-8) && near(&result["w"], &[0.0, 0.0], 1e-8), "{result}");
        let trace = folder.read("trace.csv");
        let lines: Vec<&str> = trace.lines().collect();
        assert_eq!(lines[0], "sweep,residual");
        assert_eq!(lines.len() as u64 - 1, result["sweeps"].as_u64().unwrap(), "{method}");
        let last: f64 = lines.last().unwrap().split(',').next_back().unwrap().parse().unwrap();
        assert!((last - result["residual"].as_f64().unwrap()).abs() < 1e-12, "{method}");
    }
}

#[test]
fn sweeps_and_tolerance_end_it() {
    let folder = Folder::new("lcp_limits");
    folder.write("stack.json", STACK);
    let result = folder.json(&["lcp", "stack.json", "--method", "pgs", "--sweeps", "3"]);
    assert_eq!((&result["status"], &result["sweeps"]), (&json!("limit"), &json!(3)));
    assert!(near(&result["lambda"], &[1.75, 0.875], 1e-12), "{result}");
    let result = folder.json(&["lcp", "stack.json", "--method", "pgs", "--tolerance", "0.2"]);
    assert_eq!(result["status"], "solved");
    assert!(result["sweeps"].as_u64().unwrap() < 6);
    folder.write("none.json", r#"{ "a": [[0]], "b": [-1], "lower": [0], "upper": [null] }"#);
    let result = folder.json(&["lcp", "none.json", "--method", "lemke"]);
    assert_eq!(result["status"], "infeasible");
}

#[test]
fn disks_and_boxes_are_read() {
    let folder = Folder::new("lcp_friction");
    folder.write("disk.json", pushed(true));
    folder.write("box.json", pushed(false));
    let reach = 0.5 / 2.0_f64.sqrt();
    let disk = folder.json(&["lcp", "disk.json", "--method", "pgs"]);
    assert!(near(&disk["lambda"], &[1.0, -reach, -reach], 1e-9), "{disk}");
    let square = folder.json(&["lcp", "box.json", "--method", "lemke"]);
    assert!(near(&square["lambda"], &[1.0, -0.42, -0.42], 1e-9), "{square}");
    // Eight corners, one of them along this diagonal.
    let polygon = folder.run(&["lcp", "disk.json", "--method", "lemke"]);
    assert!(stderr(&polygon).contains("polygons of 8 corners"));
    let quiet = folder.run(&["lcp", "disk.json", "--method", "lemke", "--quiet"]);
    assert_eq!(stderr(&quiet), "");
    assert_eq!(quiet.stdout, polygon.stdout);
}

#[test]
fn a_step_is_exported_and_solved() {
    let folder = Folder::with_small("lcp_export");
    let run = ["run", "small.json", "--json", "--quiet", "--steps", "240"];
    let with = folder.json(&[&run[..], &["--export-lcp", "240:step.json"]].concat());
    let without = folder.json(&run);
    assert_eq!(with["state_hash"], without["state_hash"], "looking at a step changes it");

    let file: Value = serde_json::from_str(&folder.read("step.json")).unwrap();
    let n = file["b"].as_array().unwrap().len();
    assert!(n >= 5 && file["labels"].as_array().unwrap().len() == n, "{n} rows");
    let kinds: Vec<&str> = file["labels"].as_array().unwrap().iter().map(|l| l["kind"].as_str().unwrap()).collect();
    assert!(["normal", "tangent", "joint"].iter().all(|kind| kinds.contains(kind)), "{kinds:?}");
    let joint = kinds.iter().position(|&kind| kind == "joint").unwrap();
    assert_eq!(file["labels"][joint]["bodies"], json!(["ground", "door"]));

    let solve = |method: &str, more: &[&str]| {
        folder.json(&[&["lcp", "step.json", "--method", method, "--quiet", "--sweeps", "100000"], more].concat())
    };
    let cold = solve("pgs", &[]);
    assert_eq!(cold["status"], "solved");
    assert_eq!(solve("block-pgs", &[])["status"], "solved");
    let first = |more: &[&str]| {
        let arguments = ["lcp", "step.json", "--method", "pgs", "--sweeps", "1"];
        folder.json(&[&arguments[..], more].concat())["residual"].as_f64().unwrap()
    };
    assert!(first(&["--warm"]) < 0.5 * first(&[]), "{} and {}", first(&["--warm"]), first(&[]));

    let late = folder.run(&["run", "small.json", "--steps", "10", "--export-lcp", "20:late.json"]);
    assert_eq!(late.status.code(), Some(2));
    assert!(stderr(&late).contains("step 20 is beyond the run, which has 10 steps"), "{}", stderr(&late));
    assert!(!folder.files().contains(&"late.json".to_string()));
    for (argument, words) in [("step.json", "must be STEP:FILE"), ("0:step.json", "the step must be a whole number")] {
        let wrong = folder.run(&["run", "small.json", "--export-lcp", argument]);
        assert_eq!(wrong.status.code(), Some(2));
        assert!(stderr(&wrong).contains(words), "{}", stderr(&wrong));
    }
}

#[test]
fn files_that_are_wrong_are_refused_with_their_place() {
    let folder = Folder::new("lcp_bad");
    let good = r#"{ "a": [[1, 0], [0, 1]], "b": [-1, 1], "lower": [0, null], "upper": [null, null], "mu_of": [null, 0], "mu": [0, 1], "disk": [null, null], "group": [0, 0], "start": [0, 0] }"#;
    folder.write("good.json", good);
    folder.ok(&["lcp", "good.json", "--method", "pgs", "--warm"]);
    for (from, to, words) in [
        ("[0, 1]]", "[0, null]]", "a[1][1]: must be a finite number, is null"),
        ("[0, 1]]", "[0, 1e999]]", "number out of range"),
        ("[0, 1]]", "[0]]", "a[1]: must have 2 entries, has 1"),
        ("[[1, 0], [0, 1]]", "[[1, 0]]", "a: must have 2 rows, as many as b has entries, has 1"),
        ("[[1, 0], [0, 1]]", "[[1, 0], 7]", "a[1]: must be a list, is 7"),
        ("\"b\": [-1, 1]", "\"b\": [-1, \"x\"]", "b[1]: must be a finite number, is a text"),
        ("\"b\": [-1, 1], ", "", "b: is missing"),
        ("\"lower\": [0, null]", "\"lower\": [0]", "lower: must have 2 entries, one for each row, has 1"),
        (
            "\"lower\": [0, null]",
            "\"lower\": [0, true]",
            "lower[1]: must be a finite number, is true (null for infinite)",
        ),
        ("\"upper\": [null, null]", "\"upper\": [-1, null]", "lower[0]: is 0, above upper[0], which is -1"),
        ("\"mu_of\": [null, 0]", "\"mu_of\": [null, 5]", "mu_of[1]: names row 5, but there are 2"),
        ("\"mu_of\": [null, 0]", "\"mu_of\": [null, 0.5]", "mu_of[1]: must be a whole number ≥ 0, is 0.5"),
        ("\"mu_of\": [null, 0]", "\"mu_of\": [null, []]", "mu_of[1]: must name at least one row"),
        ("\"mu\": [0, 1]", "\"mu\": [0, null]", "mu[1]: must be a finite number, is null"),
        ("\"mu\": [0, 1]", "\"mu\": [0, -1]", "mu[1]: must be finite and ≥ 0"),
        ("\"disk\": [null, null]", "\"disk\": [null, 0]", "disk[1]: names row 0: it must name 1 back"),
        ("\"disk\": [null, null]", "\"disk\": [1, null]", "disk[0]: row 0 has no normal in mu_of"),
        ("\"group\": [0, 0]", "\"group\": [0]", "group: must have 2 entries"),
        ("\"start\": [0, 0]", "\"start\": [0, 0, 0]", "start: must have 2 entries"),
        ("\"start\"", "\"begin\"", "begin: no such field"),
        ("\"mu_of\": [null, 0], ", "", "mu: means nothing without mu_of"),
        ("\"group\": [0, 0], \"start\": [0, 0] }", "", "line 1 column"),
    ] {
        let bad = good.replacen(from, to, 1);
        assert_ne!(bad, good, "{from}");
        folder.write("bad.json", &bad);
        let output = folder.run(&["lcp", "bad.json", "--method", "pgs", "--trace", "trace.csv"]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.starts_with("error: bad.json: ") && message.contains(words), "{words}: {message}");
    }
    assert!(!folder.files().contains(&"trace.csv".to_string()));
}

#[test]
fn arguments_that_are_wrong_are_refused() {
    let folder = Folder::new("lcp_arguments");
    folder.write("stack.json", STACK);
    folder.write("empty.json", "");
    for (arguments, words) in [
        (&["lcp", "stack.json"][..], "--method"),
        (&["lcp", "stack.json", "--method", "magic"], "must be one of lemke, jacobi"),
        (&["lcp", "stack.json", "--method", "pgs", "--sweeps", "0"], "must be a whole number from 1"),
        (&["lcp", "stack.json", "--method", "pgs", "--tolerance", "-1"], "must be a number ≥ 0"),
        (&["lcp", "stack.json", "--method", "pgs", "--relaxation", "2"], "between 0 and 2"),
        (&["lcp", "stack.json", "--method", "pgs", "--order", "up"], "must be fixed, random or alternating"),
        (&["lcp", "stack.json", "--method", "pgs", "--warm"], "--warm needs \"start\" in the file"),
        (&["lcp", "stack.json", "--method", "pgs", "--trace", "no/such/trace.csv"], "cannot be written"),
        (&["lcp", "missing.json", "--method", "pgs"], "missing.json: "),
        (&["lcp", ".", "--method", "pgs"], "is a directory"),
        (&["lcp", "empty.json", "--method", "block-pgs"], "the file ends where the dimension should be"),
    ] {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(stderr(&output).contains(words), "{arguments:?}: {}", stderr(&output));
    }
}

#[test]
fn frictional_contacts_give_their_error_by_sweep() {
    let folder = Folder::new("lcp_contacts");
    // Two contacts of one body of 1 kg, pushed aside beyond what friction holds.
    let block = "1 0 0 0 1 0 0 0 1";
    let text = format!(
        "3\n2\n1\n6\n6\n4\n2\n2\n3 6\n3 6\n3\n4\n0 2 4\n0 1 0 1\n0\n{block}\n1\n{block}\n2\n{block}\n3\n{block}\n\
         -2 3 0 -2 3 0\n0.5 0.5\n"
    );
    folder.write("two.dat", text);
    for method in ["block-pgs", "pgs"] {
        let result = folder.json(&["lcp", "two.dat", "--method", method, "--trace", "trace.csv"]);
        assert_eq!(result["status"], "solved", "{result}");
        let errors = numbers(&result["errors"]);
        assert_eq!(errors.len() as u64, result["sweeps"].as_u64().unwrap());
        assert_eq!(errors.last().copied(), result["error"].as_f64());
        assert_eq!(folder.read("trace.csv").lines().count(), errors.len() + 1);
        let reactions: Vec<Vec<f64>> = result["reaction"].as_array().unwrap().iter().map(numbers).collect();
        let sum = |k: usize| reactions.iter().map(|r| r[k]).sum::<f64>();
        assert!((sum(0) - 2.0).abs() < 1e-8 && (sum(1) + 1.0).abs() < 1e-8, "{result}");
    }
    let refused = folder.run(&["lcp", "two.dat", "--method", "lemke"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("friction-contact problems take block-pgs or pgs"));
}
