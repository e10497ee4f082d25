//! What JavaScript sees. Errors are thrown as `Error` with the message of the engine.
#![cfg_attr(
    target_arch = "wasm32",
    expect(clippy::needless_pass_by_value, reason = "wasm-bindgen hands over what it made")
)]

use crate::{Overlay, Source, Testbed, contact_arrows, controls, lines};
use ishigaki::report::Stage;
use ishigaki::{StepReport, Vec3};
use ishigaki_scenes::{list, list_options};
use serde_json::{Value, json};
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// Milliseconds.
    #[wasm_bindgen(js_namespace = performance, js_name = now)]
    fn performance_now() -> f64;
}

/// All named scenes as JSON: `[{ name, summary, parameters: [{ name, default, least, most, unit, whole, doc }] }]`.
#[wasm_bindgen]
pub fn scenes() -> String {
    let scenes: Vec<Value> = list()
        .iter()
        .map(|scene| {
            let parameters: Vec<Value> = scene
                .parameters
                .iter()
                .map(|p| {
                    json!({ "name": p.name, "default": p.default, "least": p.range.0, "most": p.range.1,
                            "unit": p.unit, "whole": p.whole, "doc": p.doc })
                })
                .collect();
            json!({ "name": scene.name, "summary": scene.summary, "parameters": parameters })
        })
        .collect();
    Value::from(scenes).to_string()
}

/// One control for each option as JSON: `[{ path, kind, default, doc, group_doc }]`.
#[wasm_bindgen(js_name = optionControls)]
pub fn option_controls() -> String {
    to_json(&controls())
}

/// Version of the engine.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_string()
}

/// A scene that runs.
#[wasm_bindgen(js_name = Testbed)]
#[derive(Debug)]
pub struct JsTestbed {
    testbed: Testbed,
    numbers: Vec<f32>,
}

#[wasm_bindgen(js_class = Testbed)]
impl JsTestbed {
    /// A named scene; `parameters` is a JSON object of numbers.
    pub fn named(name: &str, parameters: &str) -> Result<Self, JsError> {
        let parameters: std::collections::BTreeMap<String, f64> = serde_json::from_str(parameters)?;
        Self::build(&Source::Named(name.to_string(), parameters.into_iter().collect()))
    }

    /// A scene file (JSON) or a model (MJCF, URDF) by its name and text.
    #[wasm_bindgen(js_name = fromFile)]
    pub fn from_file(name: &str, text: &str) -> Result<Self, JsError> {
        Self::build(&Source::File(name.to_string(), text.to_string()))
    }

    fn build(source: &Source) -> Result<Self, JsError> {
        Ok(Self { testbed: Testbed::new(source)?, numbers: Vec::new() })
    }

    /// Name, description, dt, camera and warnings as JSON.
    pub fn about(&self) -> String {
        let scene = self.testbed.scene();
        json!({ "name": scene.name, "description": scene.description, "dt": scene.dt, "steps": scene.steps,
                "camera": scene.camera, "warnings": self.testbed.warnings(),
                "length_scale": self.testbed.world().options().length_scale })
        .to_string()
    }

    /// Back to the start with the options of now.
    pub fn reset(&mut self) -> Result<(), JsError> {
        Ok(self.testbed.reset()?)
    }

    /// Sets an option by its path.
    #[wasm_bindgen(js_name = setOption)]
    pub fn set_option(&mut self, path: &str, value: &str) -> Result<(), JsError> {
        Ok(self.testbed.set_option(path, value)?)
    }

    /// All options as JSON: `[[path, value], …]`, values in the words that `setOption` takes.
    pub fn options(&self) -> String {
        to_json(&list_options(self.testbed.world().options()))
    }

    /// One step of `dt` seconds; its report as JSON.
    pub fn step(&mut self, dt: f32) -> String {
        let report = self.testbed.step(dt, &mut || performance_now() / 1000.0);
        self.describe(&report)
    }

    fn describe(&self, report: &StepReport) -> String {
        let mut value = serde_json::to_value(report).unwrap_or_default();
        let stages: Vec<(&str, f64)> = Stage::ALL.iter().map(|s| s.name()).zip(report.stage_seconds).collect();
        value["stages"] = json!(stages);
        value["step"] = json!(self.testbed.world().step_count());
        value["time"] = json!(self.testbed.world().time());
        value.to_string()
    }

    /// The report of the last step as JSON, without timings.
    pub fn report(&self) -> String {
        self.describe(self.testbed.world().report())
    }

    /// Bodies, shapes and joints as JSON, as in a recording (`docs/recording-format.md`); ask again when [`geometryVersion`](Self::geometry_version) changes.
    pub fn geometry(&self) -> String {
        to_json(&self.testbed.description())
    }

    /// Raised whenever bodies come or go.
    #[wasm_bindgen(js_name = geometryVersion)]
    pub fn geometry_version(&self) -> u32 {
        self.testbed.geometry_version()
    }

    /// Seven numbers for each body: position (m), quaternion x, y, z, w.
    pub fn poses(&mut self) -> Vec<f32> {
        self.testbed.write_poses(&mut self.numbers);
        self.numbers.clone()
    }

    /// Four numbers for each body: state, height, island, speed.
    pub fn states(&mut self) -> Vec<f32> {
        self.testbed.write_states(&mut self.numbers);
        self.numbers.clone()
    }

    /// Eight numbers for each contact point: position, direction of the push, λ/m (m/s), frozen.
    pub fn contacts(&self) -> Vec<f32> {
        contact_arrows(self.testbed.world())
    }

    /// Segments of an overlay, 14 numbers each; empty for a name that does not exist.
    pub fn lines(&self, overlay: &str) -> Vec<f32> {
        Overlay::from_name(overlay).map(|o| lines(self.testbed.world(), o)).unwrap_or_default()
    }

    /// The dynamic body that a ray meets: `[place, x, y, z]`, or nothing.
    pub fn pick(&self, ox: f32, oy: f32, oz: f32, dx: f32, dy: f32, dz: f32) -> Vec<f32> {
        let hit = self.testbed.pick(Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
        hit.map(|(place, point)| vec![place as f32, point.x, point.y, point.z]).unwrap_or_default()
    }

    /// Holds a body at a point; `false` if there is none.
    pub fn grab(&mut self, place: usize, x: f32, y: f32, z: f32) -> bool {
        self.testbed.grab(place, Vec3::new(x, y, z))
    }

    /// Moves the end of the spring.
    pub fn drag(&mut self, x: f32, y: f32, z: f32) {
        self.testbed.drag(Vec3::new(x, y, z));
    }

    /// Lets go.
    pub fn release(&mut self) {
        self.testbed.release();
    }

    /// The held point and where it is pulled to: six numbers, or nothing.
    pub fn grabbed(&self) -> Vec<f32> {
        let ends = self.testbed.grabbed();
        ends.map(|(a, b)| [a.to_array(), b.to_array()].concat()).unwrap_or_default()
    }

    /// Throws a ball.
    #[expect(clippy::too_many_arguments, reason = "two vectors cross as six numbers")]
    pub fn shoot(
        &mut self,
        ox: f32,
        oy: f32,
        oz: f32,
        vx: f32,
        vy: f32,
        vz: f32,
        radius: f32,
        density: f32,
    ) -> Result<(), JsError> {
        Ok(self.testbed.shoot(Vec3::new(ox, oy, oz), Vec3::new(vx, vy, vz), radius, density)?)
    }

    /// The whole state as bytes.
    pub fn snapshot(&self) -> Vec<u8> {
        self.testbed.snapshot()
    }

    /// Continues from a snapshot.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), JsError> {
        Ok(self.testbed.restore(bytes)?)
    }

    /// Hash of all poses and velocities, 16 hexadecimal digits.
    #[wasm_bindgen(js_name = stateHash)]
    pub fn state_hash(&self) -> String {
        format!("{:016x}", self.testbed.world().state_hash())
    }

    /// The scene as a scene file, as it was before the first step.
    #[wasm_bindgen(js_name = sceneFile)]
    pub fn scene_file(&self) -> String {
        self.testbed.file().to_json()
    }
}

/// None of the values has a map whose keys are no strings, so none fails.
fn to_json(value: &impl serde::Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}
