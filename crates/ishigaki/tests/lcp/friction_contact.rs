//! Frictional contact problems that other simulations left behind, and files that are none.
//!
//! Files: skipped, and said so, where they are not there; an error if `ISHIGAKI_REQUIRE` names `data`.

use ishigaki::lcp::{ContactSolution, FrictionContact, Order, Settings, Status};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The folder of the collected problems, or `None` after saying that the test is skipped.
fn data() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/friction-contact");
    if folder.is_dir() {
        return Some(folder);
    }
    let message = "SKIPPED data: put the friction-contact files of Siconos into ../shared/data/friction-contact";
    let required = std::env::var("ISHIGAKI_REQUIRE").unwrap_or_default();
    assert!(!required.split([',', ' ']).any(|word| word == "data"), "{message}");
    eprintln!("{message}");
    if let Some(log) = std::env::var_os("ISHIGAKI_SKIP_LOG")
        && let Ok(mut file) = std::fs::OpenOptions::new().append(true).create(true).open(log)
    {
        // In one piece: other tests append, too.
        let _ = file.write_all(format!("{message}\n").as_bytes());
    }
    None
}

fn read(folder: &Path, name: &str) -> FrictionContact {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    FrictionContact::parse(&text).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// Coulomb's law at each contact, stated without the natural map: open, sticking or sliding. To `tolerance` of the
/// size of r and u.
fn assert_coulomb(solution: &ContactSolution, mu: f64, tolerance: f64) {
    let norm = |v: &[[f64; 3]]| v.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
    let scale = norm(&solution.reaction).max(norm(&solution.velocity));
    for (r, u) in solution.reaction.iter().zip(&solution.velocity) {
        let (reach, slide) = (r[1].hypot(r[2]), u[1].hypot(u[2]));
        assert!(r[0] >= 0.0 && u[0] >= -tolerance * scale, "{r:?} {u:?}");
        assert!(reach <= mu * r[0] + tolerance * scale, "{r:?} is out of its cone");
        assert!(r[0] <= tolerance * scale || u[0].abs() <= tolerance * scale, "{r:?} pushes at a distance: {u:?}");
        if slide > 100.0 * tolerance * scale && r[0] > 100.0 * tolerance * scale {
            assert!(reach >= 0.99 * mu * r[0], "slides at {slide} below its limit: {r:?} {u:?}");
            let along = if mu == 0.0 { -1.0 } else { (r[1] * u[1] + r[2] * u[2]) / (reach * slide) };
            assert!(along < -0.99, "friction is not against sliding: {r:?} {u:?}");
        }
    }
}

#[test]
fn problems_of_other_simulations_are_solved() {
    let Some(folder) = data() else { return };
    // The object has contacts with several exact solutions: at full steps blocks jump between them.
    for (name, contacts, mu, relaxation, tolerance) in [
        ("OneObject-i100000-499.hdf5.dat", 24, 0.3, 0.5, 1e-8),
        ("Capsules-i122-1617.dat", 296, 0.7, 1.0, 1e-6),
        ("BoxesStack1-i100000-32.hdf5.dat", 52, 0.7, 1.0, 5e-5),
    ] {
        let problem = read(&folder, name);
        assert_eq!(problem.len(), contacts);
        let settings = Settings { sweeps: 8_000, tolerance, relaxation, ..Settings::default() };
        for (kind, solution) in [
            ("blocks", problem.solve_blocks(&settings)),
            ("blocks, random order", problem.solve_blocks(&Settings { order: Order::Random, ..settings.clone() })),
            ("rows", problem.solve_rows(&settings)),
        ] {
            eprintln!("{name}, {kind}: {:.1e} after {} sweeps", solution.error, solution.sweeps);
            assert_eq!(solution.status, Status::Solved, "{name}, {kind}: {:e}", solution.error);
            assert_coulomb(&solution, mu, 100.0 * tolerance);
        }
    }
}

/// One contact with the block `w` (column by column).
fn one(w: [f64; 9], q: [f64; 3], mu: f64) -> String {
    let text = |v: &[f64]| v.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    format!("3\n1\n1\n3 3\n1\n1 1\n3\n3\n2\n1\n0 1\n0\n0\n{}\n{}\n{mu}\n", text(&w), text(&q))
}

#[test]
fn one_contact_opens_sticks_or_slides() {
    let w = [2.0, 0.3, -0.4, 0.3, 1.5, 0.2, -0.4, 0.2, 3.0];
    let solve = |q: [f64; 3], mu: f64| {
        let problem = FrictionContact::parse(&one(w, q, mu)).unwrap();
        let solution = problem.solve_blocks(&Settings { tolerance: 1e-13, ..Settings::default() });
        assert!(solution.sweeps <= 1, "one contact is one visit");
        assert_eq!(solution.status, Status::Solved, "{:e}", solution.error);
        assert_coulomb(&solution, mu, 1e-12);
        let rows = problem.solve_rows(&Settings { tolerance: 1e-12, ..Settings::default() });
        let (r, s) = (solution.reaction[0], rows.reaction[0]);
        assert!((0..3).all(|k| (r[k] - s[k]).abs() < 1e-9), "{r:?} and {s:?}");
        (r, solution.velocity[0])
    };
    assert_eq!(solve([0.1, 5.0, 5.0], 0.5).0, [0.0; 3]);
    let (_, u) = solve([-1.0, 0.05, -0.02], 0.5);
    assert!(u.iter().all(|x| x.abs() < 1e-14), "it sticks: {u:?}");
    let (r, u) = solve([-1.0, 2.0, -1.0], 0.5);
    assert!((r[1].hypot(r[2]) - 0.5 * r[0]).abs() < 1e-13 && u[1].hypot(u[2]) > 0.1);
    let (r, _) = solve([-1.0, 2.0, -1.0], 0.0);
    assert_eq!((r[1], r[2]), (0.0, 0.0));
}

#[test]
fn files_that_are_wrong_are_refused_with_their_line() {
    let good = one([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], 0.5);
    assert!(FrictionContact::parse(&good).is_ok());
    for (from, to, place, words) in [
        ("3\n1\n1", "2\n1\n1", "line 1", "the dimension must be 3, is 2"),
        ("3\n1\n1", "3\n1\n0", "line 3", "storage kind"),
        ("3\n1\n1", "3\n99999999999\n1", "line 4", "number of rows"),
        ("\n3 3\n", "\n3 4\n", "line 4", "number of columns must be 3, is 4"),
        ("\n0 1\n", "\n0 2\n", "line 11", "row starts"),
        ("1 0 0 0 1 0 0 0 1", "1 0 0 0 x 0 0 0 1", "line 14", "must be a finite number, is x"),
        ("1 0 0 0 1 0 0 0 1", "0 0 0 0 1 0 0 0 1", "line 14", "no mass along its normal"),
        ("-1 0 0", "nan 0 0", "line 15", "q must be a finite number"),
        ("0.5\n", "-0.5\n", "line 16", "μ must be ≥ 0"),
        ("0.5\n", "", "line 15", "the file ends where μ should be"),
        ("0.5\n", "0.5\n7\n", "line 17", "nothing should follow"),
    ] {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "{from}");
        let error = FrictionContact::parse(&text).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{place}:")) && error.contains(words), "{to}: {error}");
    }
    // Each prefix is refused or, never, read.
    let words: Vec<&str> = good.split_inclusive(char::is_whitespace).collect();
    for length in 0..words.len() {
        assert!(FrictionContact::parse(&words[..length].concat()).is_err(), "{length} words");
    }
}
