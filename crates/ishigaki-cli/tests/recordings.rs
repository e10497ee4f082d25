//! Recordings: made by `run`, read back, shown by `view`; and what goes wrong with them.

mod common;

use common::{Folder, stderr};
use ishigaki_recording::Recording;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

#[test]
fn a_recording_holds_the_states_of_the_run() {
    let folder = Folder::with_small("record");
    folder.ok(&["run", "small.json", "--quiet", "--record", "out.ishi", "--states", "out.csv", "--record-contacts"]);
    assert_eq!(folder.files(), ["out.csv", "out.ishi", "small.json"]);
    let bytes = std::fs::read(folder.path().join("out.ishi")).unwrap();
    let recording = Recording::read(&bytes).unwrap();
    let scene = recording.scene();
    assert_eq!((scene.name.as_str(), scene.every, scene.contacts), ("small.json", 1, true));
    assert_eq!((recording.len(), scene.bodies.len(), scene.joints.len()), (31, 4, 1));

    let table = folder.read("out.csv");
    for line in table.lines().skip(1).filter(|line| !line.contains('"')) {
        let cells: Vec<&str> = line.split(',').collect();
        let (step, body): (usize, usize) = (cells[0].parse().unwrap(), cells[2].parse().unwrap());
        let record = recording.frame(step).unwrap().bodies[body];
        let (p, q) = (record.position, record.rotation);
        let poses = [p.x, p.y, p.z, q.x, q.y, q.z, q.w];
        let expected: Vec<f32> = cells[4..11].iter().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(poses[..], expected[..], "step {step}, body {body}");
    }
    let contacts: Vec<_> = (0..31).flat_map(|i| recording.frame(i).unwrap().contacts).collect();
    assert!(contacts.iter().any(|c| c.impulse > 0.0), "something lies on the ground");
}

#[test]
fn recordings_of_named_scenes_snapshots_and_every_third_step() {
    let folder = Folder::new("record_from");
    folder.ok(&["run", "tower", "--param", "n=3", "--steps", "10", "--quiet", "--snapshot", "a.snap"]);
    folder.ok(&["run", "--from", "a.snap", "--steps", "7", "--quiet", "--record", "b.ishi", "--record-every", "3"]);
    let bytes = std::fs::read(folder.path().join("b.ishi")).unwrap();
    let recording = Recording::read(&bytes).unwrap();
    let steps: Vec<u64> = (0..recording.len()).map(|i| recording.measures(i).unwrap().step).collect();
    assert_eq!(steps, [10, 13, 16, 17]);
    assert!(!recording.scene().contacts && recording.frame(3).unwrap().contacts.is_empty());
}

#[test]
fn wrong_ways_to_record() {
    let folder = Folder::with_small("record_wrong");
    let refused = |arguments: &[&str], words: &[&str]| {
        let output = folder.run(arguments);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        words.iter().for_each(|word| assert!(message.contains(word), "{arguments:?}: {message}"));
        assert_eq!(folder.files(), ["small.json"], "nothing is left behind");
    };
    refused(&["run", "small.json", "--record-every", "2"], &["--record"]);
    refused(&["run", "small.json", "--record-contacts"], &["--record"]);
    refused(&["run", "small.json", "--record", "a", "--record-every", "0"], &["whole number"]);
    refused(&["run", "small.json", "--record", "no/such/a.ishi"], &["a.ishi", "folder"]);
    refused(&["run", "small.json", "--record", "a", "--states", "a"], &["--states", "--record", "same file"]);
    refused(&["view", "missing.ishi"], &["missing.ishi", "--record"]);
    refused(&["view", "small.json"], &["small.json", "not a recording"]);
    refused(&["view", "."], &["directory"]);
}

#[test]
fn a_recording_that_was_cut_off_is_named_with_its_place() {
    let folder = Folder::with_small("record_cut");
    folder.ok(&["run", "small.json", "--quiet", "--steps", "5", "--record", "out.ishi"]);
    let mut bytes = std::fs::read(folder.path().join("out.ishi")).unwrap();
    bytes.truncate(bytes.len() - 200);
    folder.write("cut.ishi", &bytes);
    let output = folder.run(&["view", "cut.ishi", "--no-open"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("cut.ishi: cut off"), "{}", stderr(&output));
}

/// A running `view`; ends with the test.
struct Viewer {
    child: Child,
    address: String,
}

impl Viewer {
    fn start(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("http://").and_then(|a| a.strip_suffix('/'));
        let address = address.unwrap_or_else(|| panic!("no address: {line}")).to_string();
        Self { child, address }
    }

    /// Head and body of the answer.
    fn ask(&self, request: &str) -> (String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap() + 4;
        (String::from_utf8(answer[..end].to_vec()).unwrap(), answer[end..].to_vec())
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a program without the page says, as it should.
fn page_is_missing(folder: &Folder, arguments: &[&str], files: &[&str]) -> bool {
    if Path::new(env!("CARGO_MANIFEST_DIR")).join("../../web/dist/replay.html").exists() {
        return false;
    }
    let output = folder.run(arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("just web"), "{message}");
    assert_eq!(folder.files(), files, "nothing is left behind");
    true
}

#[test]
fn view_serves_the_page_and_the_recording_on_loopback() {
    let folder = Folder::with_small("view");
    folder.ok(&["run", "small.json", "--quiet", "--record", "out.ishi"]);
    let arguments = ["view", "out.ishi", "--no-open", "--port", "0"];
    if page_is_missing(&folder, &arguments, &["out.ishi", "small.json"]) {
        return;
    }
    let viewer = Viewer::start(folder.command(&arguments));
    assert!(viewer.address.starts_with("127.0.0.1:"), "{}", viewer.address);

    let (head, page) = viewer.ask("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    assert!(head.starts_with("HTTP/1.1 200") && head.contains("text/html"), "{head}");
    assert!(String::from_utf8(page).unwrap().contains("@ISHIGAKI_RECORDING@"));

    let expected = std::fs::read(folder.path().join("out.ishi")).unwrap();
    let (head, recording) = viewer.ask("GET /recording.ishi HTTP/1.1\r\nHost: 127.0.0.1:80\r\n\r\n");
    assert!(head.contains(&format!("Content-Length: {}\r\n", expected.len())), "{head}");
    assert!(recording == expected);
    let (head, nothing) = viewer.ask("HEAD /recording.ishi HTTP/1.1\r\n\r\n");
    assert!(head.contains(&format!("Content-Length: {}\r\n", expected.len())) && nothing.is_empty());

    for (request, status) in [
        ("GET /../small.json HTTP/1.1\r\n\r\n", "404"),
        ("GET /nothing HTTP/1.1\r\n\r\n", "404"),
        ("POST / HTTP/1.1\r\n\r\n", "405"),
        ("GET / HTTP/1.1\r\nHost: elsewhere.example\r\n\r\n", "403"),
        ("hello\r\n\r\n", "400"),
    ] {
        let (head, _) = viewer.ask(request);
        assert!(head.starts_with(&format!("HTTP/1.1 {status} ")), "{request}: {head}");
    }
}

#[test]
fn html_is_the_page_with_the_recording_inside() {
    let folder = Folder::with_small("html");
    let arguments = ["run", "small.json", "--quiet", "--html", "out.html", "--record", "out.ishi"];
    if page_is_missing(&folder, &arguments, &["small.json"]) {
        return;
    }
    folder.ok(&arguments);
    let page = folder.read("out.html");
    assert!(!page.contains("@ISHIGAKI_RECORDING@"));
    let start = page.find(r#"<script id="recording" type="application/octet-stream;base64">"#).unwrap();
    let text = page[start..].split_once('>').unwrap().1.split_once('<').unwrap().0;
    let zipped = base64::Engine::decode(&base64::engine::general_purpose::STANDARD, text).unwrap();
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(&zipped[..]).read_to_end(&mut bytes).unwrap();
    assert!(bytes == std::fs::read(folder.path().join("out.ishi")).unwrap());
}

/// Width and height of a PNG.
fn png_size(path: &Path) -> (u32, u32) {
    let bytes = std::fs::read(path).unwrap();
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let number = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}

#[test]
fn pictures_of_frames_and_times() {
    let folder = Folder::with_small("picture");
    folder.ok(&["run", "small.json", "--quiet", "--steps", "30", "--record", "a.ishi", "--record-contacts"]);
    let draw = |name: &str, more: &[&str]| {
        let arguments = [&["picture", "a.ishi", "--png", name, "--size", "80x45", "--samples", "1"], more].concat();
        assert_eq!(folder.ok(&arguments), "");
        assert_eq!(png_size(&folder.path().join(name)), (80, 45));
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let (last, start) = (draw("last.png", &[]), draw("start.png", &["--frame", "0"]));
    assert!(last != start, "things fell");
    assert!(draw("b.png", &["--frame", "30"]) == last);
    assert!(draw("b.png", &["--time", "99"]) == last);
    assert!(draw("b.png", &["--time", "0"]) == start);
    assert!(draw("b.png", &["--contacts"]) != last);
    assert!(draw("b.png", &["--camera", "-5,3,8:0,1,0"]) != last);
    assert!(draw("b.png", &["--color", "island"]) != last);
}

#[test]
fn wrong_ways_to_draw() {
    let folder = Folder::with_small("picture_wrong");
    folder.ok(&["run", "small.json", "--quiet", "--steps", "5", "--record", "a.ishi"]);
    for (more, words) in [
        (&["--frame", "6"][..], &["--frame 6", "0 to 5"][..]),
        (&["--contacts"], &["--record-contacts"]),
        (&["--size", "0x5"], &["WIDTHxHEIGHT"]),
        (&["--size", "wide"], &["WIDTHxHEIGHT"]),
        (&["--camera", "1,2:3"], &["4,2,6:0,1,0"]),
        (&["--camera", "1,2,3:1,2,3"], &["another point"]),
        (&["--color", "mood"], &["name, height, island or state"]),
        (&["--samples", "99"], &["99"]),
        (&["--frame", "1", "--time", "1"], &["--time"]),
        (&["--png", "no/such/b.png"], &["no/such/b.png"]),
    ] {
        let png: &[&str] = if more.contains(&"--png") { &[] } else { &["--png", "b.png"] };
        let output = folder.run(&[&["picture", "a.ishi"], png, more].concat());
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {message}");
        words.iter().for_each(|word| assert!(message.contains(word), "{more:?}: {message}"));
        assert_eq!(folder.files(), ["a.ishi", "small.json"], "nothing is left behind");
    }
    let output = folder.run(&["picture", "small.json", "--png", "b.png"]);
    assert!(stderr(&output).contains("not a recording"), "{}", stderr(&output));
}
