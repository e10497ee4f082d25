//! Pictures show what is there, where it is, the same every time; odd recordings do no harm.

use ishigaki::{Body, Shape, Vec3, World};
use ishigaki_picture::{Camera, Coloring, Picture, Style, render};
use ishigaki_recording::{About, Recorder, Recording};

const STYLE: Style =
    Style { width: 64, height: 48, samples: 1, camera: None, coloring: Coloring::Name, contacts: false };

fn ground() -> Body {
    Body::fixed(Shape::half_space(Vec3::Y))
}

/// Steps a world and draws the last frame.
fn picture_of(bodies: Vec<Body>, steps: usize, style: &Style) -> Picture {
    let mut world = World::default();
    world.add_bodies(bodies).unwrap();
    let mut recorder = Recorder::new(Vec::new(), &world, &About { contacts: true, ..About::default() }).unwrap();
    for _ in 0..steps {
        world.step(1.0 / 60.0);
        recorder.step(&world).unwrap();
    }
    let bytes = recorder.finish(&world).unwrap();
    let recording = Recording::read(&bytes).unwrap();
    render(recording.scene(), &recording.frame(steps).unwrap(), style)
}

fn at(picture: &Picture, x: usize, y: usize) -> [i32; 3] {
    let i = 3 * (y * picture.width + x);
    [0, 1, 2].map(|k| i32::from(picture.rgb[i + k]))
}

/// How colorful a pixel is: ground and sky are nearly gray, bodies are not.
fn chroma(pixel: [i32; 3]) -> i32 {
    pixel.iter().max().unwrap() - pixel.iter().min().unwrap()
}

/// Columns and rows of all colorful pixels: (least, greatest).
fn extent(picture: &Picture) -> Option<((usize, usize), (usize, usize))> {
    let (width, height) = (picture.width, picture.height);
    let colorful: Vec<(usize, usize)> =
        (0..width * height).map(|i| (i % width, i / width)).filter(|&(x, y)| chroma(at(picture, x, y)) > 30).collect();
    let columns = colorful.iter().map(|p| p.0);
    let rows = colorful.iter().map(|p| p.1);
    Some(((columns.clone().min()?, columns.max()?), (rows.clone().min()?, rows.max()?)))
}

#[test]
fn what_moves_fills_the_picture_and_is_in_its_middle() {
    for (place, size) in [(Vec3::ZERO, 1.0), (Vec3::new(500.0, 0.0, -300.0), 1.0), (Vec3::ZERO, 40.0)] {
        let bodies = (0..6).map(|i| {
            let half = 0.5 * size;
            Body::dynamic(Shape::cuboid(half, half, half)).at(place + Vec3::Y * size * (i as f32 + 0.5))
        });
        let picture = picture_of([ground()].into_iter().chain(bodies).collect(), 0, &STYLE);
        let ((left, right), (top, bottom)) = extent(&picture).expect("a tower");
        assert!((2..9).contains(&top) && (39..46).contains(&bottom), "rows {top} to {bottom}");
        assert!((left + right).abs_diff(63) <= 4, "columns {left} to {right}");
        assert!(right - left < 20, "a tower is narrow: columns {left} to {right}");
    }
}

#[test]
fn one_body_that_flew_away_does_not_make_the_others_small() {
    let mut bodies: Vec<Body> = vec![ground()];
    bodies.extend((0..8).map(|i| Body::dynamic(Shape::cuboid(0.5, 0.5, 0.5)).at(Vec3::Y * (i as f32 + 0.5))));
    bodies.push(Body::dynamic(Shape::ball(0.5)).at(Vec3::new(9000.0, 2000.0, 0.0)));
    let (_, (top, bottom)) = extent(&picture_of(bodies, 0, &STYLE)).expect("a tower");
    assert!(bottom - top > 30, "rows {top} to {bottom}");
}

#[test]
fn a_body_throws_a_shadow_on_the_ground() {
    let camera = Some(Camera { eye: Vec3::new(0.0, 12.0, 12.0), target: Vec3::ZERO });
    let style = Style { camera, samples: 2, ..STYLE };
    let with = picture_of(vec![ground(), Body::dynamic(Shape::ball(0.8)).at(Vec3::Y * 0.8)], 0, &style);
    let without = picture_of(vec![ground()], 0, &style);
    let brightness = |p: [i32; 3]| p.iter().sum::<i32>();
    let is_dark = |x: usize, y: usize| brightness(at(&with, x, y)) < brightness(at(&without, x, y)) - 120;
    let gray_and_dark = |&(x, y): &(usize, usize)| is_dark(x, y) && chroma(at(&with, x, y)) < 25;
    let pixels: Vec<(usize, usize)> = (0..64 * 48).map(|i| (i % 64, i / 64)).filter(gray_and_dark).collect();
    assert!(pixels.len() > 15, "{} pixels of shadow", pixels.len());
    // The sun stands on the left and behind the eye: shadows fall to the right and up.
    let mean = |f: fn(&(usize, usize)) -> usize| pixels.iter().map(f).sum::<usize>() as f32 / pixels.len() as f32;
    assert!(mean(|p| p.0) > 33.0 && mean(|p| p.1) < 25.0, "{} {}", mean(|p| p.0), mean(|p| p.1));
}

#[test]
fn the_same_frame_is_the_same_picture() {
    let bodies = || vec![ground(), Body::dynamic(Shape::capsule(0.5, 0.3)).at(Vec3::Y)];
    assert!(picture_of(bodies(), 20, &STYLE) == picture_of(bodies(), 20, &STYLE));
}

#[test]
fn near_walls_do_not_hide_what_is_behind_them() {
    let walls = |radius: f32| {
        let wall = |at: Vec3, half: Vec3| Body::fixed(Shape::cuboid(half.x, half.y, half.z)).at(at);
        let (long, thin) = (radius, 0.1);
        vec![
            wall(Vec3::new(radius, 1.0, 0.0), Vec3::new(thin, 1.0, long)),
            wall(Vec3::new(-radius, 1.0, 0.0), Vec3::new(thin, 1.0, long)),
            wall(Vec3::new(0.0, 1.0, radius), Vec3::new(long, 1.0, thin)),
            wall(Vec3::new(0.0, 1.0, -radius), Vec3::new(long, 1.0, thin)),
        ]
    };
    let mut bodies = vec![ground()];
    bodies.extend(walls(1.0));
    bodies.push(Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * 0.5));
    let picture = picture_of(bodies, 0, &STYLE);
    assert!(extent(&picture).is_some(), "the ball cannot be seen");
}

#[test]
fn contacts_are_drawn_on_demand() {
    let bodies = || vec![ground(), Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * 0.5)];
    let red = |picture: &Picture| {
        let is_red = |p: &&[u8]| p[0] > 120 && p[1] < 90 && p[2] < 90;
        picture.rgb.chunks_exact(3).filter(is_red).count()
    };
    let style = Style { samples: 2, ..STYLE };
    assert_eq!(red(&picture_of(bodies(), 30, &style)), 0);
    assert!(red(&picture_of(bodies(), 30, &Style { contacts: true, ..style })) > 0);
}

#[test]
fn every_coloring_draws_something_else() {
    let bodies = || (0..4).map(|i| Body::dynamic(Shape::ball(0.5)).at(Vec3::Y * (i as f32 + 0.5)));
    let draw = |coloring| picture_of([ground()].into_iter().chain(bodies()).collect(), 3, &Style { coloring, ..STYLE });
    let pictures: Vec<Picture> = Coloring::ALL.into_iter().map(|(_, coloring)| draw(coloring)).collect();
    for (i, picture) in pictures.iter().enumerate() {
        assert!(!pictures[..i].contains(picture), "{:?} looks like another", Coloring::ALL[i]);
    }
}

#[test]
fn nothing_and_what_is_not_finite_can_be_drawn() {
    let empty = picture_of(vec![], 1, &STYLE);
    assert_eq!(empty.rgb.len(), 3 * 64 * 48);
    let mut odd = vec![ground(), Body::fixed(Shape::half_space(Vec3::NEG_X))];
    odd.push(Body::dynamic(Shape::ball(0.5)).velocity(Vec3::splat(3e38)));
    odd.push(Body::dynamic(Shape::cuboid(1e-3, 1e5, 1e-3)));
    picture_of(odd, 3, &STYLE);
    let one = picture_of(vec![ground()], 0, &Style { width: 1, height: 1, ..STYLE });
    let mut png = Vec::new();
    one.write_png(&mut png).unwrap();
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
}
