//! Options by path.

use ishigaki::{Permutation, SolverOptions, Vec3, WorldOptions};
use ishigaki_scenes::{list_options, set_option};

#[test]
fn every_option_can_be_set_to_what_it_is() {
    let before = WorldOptions::default();
    for (path, value) in list_options(&before) {
        let mut options = before.clone();
        set_option(&mut options, &path, &value).unwrap_or_else(|e| panic!("{path}={value}: {e}"));
        // Setting a number switches its technique on; nothing else may change.
        if options != before {
            let (technique, _) = path.rsplit_once('.').unwrap();
            set_option(&mut options, technique, "off").unwrap();
            assert_eq!(options, before, "{path}={value}");
        }
    }
}

#[test]
fn setting_a_number_switches_its_technique_on() {
    let mut options = WorldOptions::default();
    set_option(&mut options, "solver.weight_amplification", "off").unwrap();
    set_option(&mut options, "solver.weight_amplification.factor", "1.7").unwrap();
    assert!(options.solver.weight_amplification.enabled);
    assert_eq!(options.solver.weight_amplification.factor, 1.7);
    set_option(&mut options, "solver.weight_amplification.enabled", "false").unwrap();
    assert!(!options.solver.weight_amplification.enabled);
    set_option(&mut options, "solver.weight_amplification", "on").unwrap();
    assert!(options.solver.weight_amplification.enabled);
}

#[test]
fn presets_enums_vectors_groups() {
    let mut options = WorldOptions::default();
    for (name, preset) in
        [("plain", SolverOptions::plain()), ("talk", SolverOptions::talk()), ("default", SolverOptions::default())]
    {
        set_option(&mut options, "solver", name).unwrap();
        assert_eq!(options.solver, preset);
    }
    set_option(&mut options, "solver.permutation", "per_step").unwrap();
    assert_eq!(options.solver.permutation, Permutation::PerStep);
    set_option(&mut options, "gravity", "[0, 0, -1.62]").unwrap();
    assert_eq!(options.gravity, Vec3::new(0.0, 0.0, -1.62));
    set_option(&mut options, "seed", "18446744073709551615").unwrap();
    assert_eq!(options.seed, u64::MAX);
    set_option(&mut options, "solver.slop", r#"{"enabled": false, "depth": 0.01}"#).unwrap();
    assert_eq!((options.solver.slop.enabled, options.solver.slop.depth), (false, 0.01));
}
