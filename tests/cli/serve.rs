//! `romrun --serve`: the protocol against a server without a socket, then the program itself.

use std::io::{BufRead, BufReader, Read};
use std::net::{SocketAddr, UdpSocket};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

use assert_cmd::cargo::CommandCargoExt;
use rom_cli::serve::packet::{Kind, Writer};
use rom_cli::serve::{Counts, Options, Server};
use rom_runtime::{InitialState, Integrator, LoadCase, LoadFrame, LoadSet, Model, Settings, Simulation};

use super::{frame, refused, romrun, text};

const HOST: ([u8; 4], u16) = ([127, 0, 0, 1], 4000);
const SESSION: u32 = 7;

fn host() -> SocketAddr {
    HOST.into()
}

fn server(settings: Settings) -> (Arc<Model>, Server) {
    let model = Arc::new(Model::read_path(frame()).unwrap());
    let points = (0..model.n_points()).collect();
    let options = Options { settings, case: None, points, point_motion: true };
    let server = Server::new(&model, options).unwrap();
    (model, server)
}

fn request(kind: Kind, sequence: u32, payload: &[u8]) -> Vec<u8> {
    let mut writer = Writer::default();
    writer.begin(kind as u16, SESSION, sequence);
    writer.bytes(payload);
    writer.finish().to_vec()
}

fn hello(server: &mut Server) {
    assert!(server.answer(&request(Kind::Hello, 0, &[]), host()).is_some());
}

/// Steps under a moment on the point `P` about y of A.
fn step(sequence: u32, steps: u32, point: u32, moment: f64) -> Vec<u8> {
    let mut payload = Vec::new();
    for word in [steps, 1, point, 1] {
        payload.extend(word.to_le_bytes());
    }
    for value in [0.0, 0.0, 0.0, 0.0, moment, 0.0] {
        payload.extend(f64::to_le_bytes(value));
    }
    request(Kind::Step, sequence, &payload)
}

fn numbers(reply: &[u8]) -> Vec<f64> {
    let payload = &reply[24 + 8..reply.len() - 4];
    payload.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect()
}

fn kind(reply: &[u8]) -> u16 {
    u16::from_le_bytes([reply[6], reply[7]])
}

#[test]
fn a_host_gets_what_the_runtime_computes() {
    for integrator in [Integrator::Newmark, Integrator::Rk4, Integrator::GeneralizedAlpha] {
        let settings = Settings { dt: 0.002, integrator, ..Settings::default() };
        let (model, mut server) = server(settings);
        let point = model.point("P").unwrap();
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        let mut loads = LoadSet::new(&model, &[point]).unwrap();
        hello(&mut server);
        for sequence in 1..20 {
            let moment = 10.0 * f64::from(sequence);
            let reply = server.answer(&step(sequence, 5, point as u32, moment), host()).unwrap();
            assert_eq!(kind(reply), 0x8003);
            loads.clear();
            assert!(loads.add(0, &LoadFrame::Body, [0.0; 3], [0.0, moment, 0.0]));
            (0..5).for_each(|_| simulation.step(&loads).unwrap());
            simulation.solve_accelerations(&loads).unwrap();
            let found = numbers(reply);
            let (rigid, motion) = (simulation.rigid_output(), simulation.point_motion(point).unwrap());
            let at = 32 + model.n_modes() + 22 * point;
            let expected = [(0, vec![simulation.state().time]), (1, rigid.r_g.to_vec())];
            let more =
                [(7, rigid.w_g.to_vec()), (16, rigid.zeta.to_vec()), (32, simulation.state().q.clone())];
            let points = [
                (at, simulation.point_output(point).unwrap().dr_a.to_vec()),
                (at + 6, motion.attitude.to_vec()),
                (at + 19, motion.alpha_g.to_vec()),
            ];
            for (from, values) in expected.into_iter().chain(more).chain(points) {
                // The loads of the server are those of all points: sums in another order.
                for (i, value) in values.iter().enumerate() {
                    let scale = 1e-12 * (1.0 + value.abs());
                    assert!((found[from + i] - value).abs() < scale, "{integrator:?} {from} + {i}");
                }
            }
            assert_eq!(found.len(), 32 + model.n_modes() + 22 * model.n_points());
        }
    }
}

#[test]
fn packets_sent_again_are_not_done_again_and_old_ones_not_at_all() {
    let (_, mut server) = server(Settings::default());
    hello(&mut server);
    let packet = step(u32::MAX, 3, 0, 1.0);
    // u32::MAX is just before the hello: old.
    assert!(server.answer(&packet, host()).is_none());
    let first = server.answer(&step(1, 3, 0, 1.0), host()).unwrap().to_vec();
    for _ in 0..3 {
        assert_eq!(server.answer(&step(1, 3, 0, 1.0), host()).unwrap(), first);
    }
    assert!(server.answer(&step(1, 3, 0, 2.0), host()).is_none(), "another packet under its number");
    let second = server.answer(&step(9, 3, 0, 1.0), host()).unwrap().to_vec();
    assert_ne!(second, first);
    assert!(server.answer(&step(1, 3, 0, 1.0), host()).is_none());
    assert_eq!(server.counts.steps, 6);
    // Round the end of the numbers.
    for sequence in [0x7fff_0000, 0xfffe_0000, u32::MAX, 2] {
        assert!(server.answer(&step(sequence, 1, 0, 0.0), host()).is_some(), "{sequence}");
    }
    let other: SocketAddr = ([127, 0, 0, 1], 4001).into();
    assert!(server.answer(&step(3, 1, 0, 0.0), other).is_none(), "another sender");
    let counts = Counts {
        received: 14,
        answered: 7,
        repeated: 3,
        stale: 3,
        strangers: 1,
        steps: 10,
        ..Counts::default()
    };
    assert_eq!(server.counts, counts);
}

#[test]
fn states_are_saved_and_set_again_to_the_bit() {
    let (_, mut server) = server(Settings::default());
    hello(&mut server);
    let slot = |kind, sequence, slot: u32| request(kind, sequence, &slot.to_le_bytes());
    let start = numbers(server.answer(&request(Kind::Read, 1, &[]), host()).unwrap());
    server.answer(&step(2, 50, 0, 30.0), host()).unwrap();
    let saved = numbers(server.answer(&slot(Kind::Snapshot, 3, 15), host()).unwrap());
    let end = numbers(server.answer(&step(4, 50, 0, -30.0), host()).unwrap());
    assert_eq!(numbers(server.answer(&slot(Kind::Restore, 5, 15), host()).unwrap()), saved);
    assert_eq!(numbers(server.answer(&step(6, 50, 0, -30.0), host()).unwrap()), end);
    assert_eq!(numbers(server.answer(&request(Kind::Reset, 7, &[]), host()).unwrap()), start);
    server.answer(&step(8, 50, 0, 30.0), host()).unwrap();
    assert_eq!(numbers(server.answer(&step(9, 50, 0, -30.0), host()).unwrap()), end);
    // A start in motion: at 5 m/s along x of A, turned by half about z.
    let motion = [0.0, 0.0, 9.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let motion: Vec<u8> = motion.iter().flat_map(|x| f64::to_le_bytes(*x)).collect();
    let moving = numbers(server.answer(&request(Kind::Reset, 10, &motion), host()).unwrap());
    assert_eq!((&moving[1..4], &moving[10..13]), (&[0.0, 0.0, 9.0][..], &[5.0, 0.0, 0.0][..]));
    assert!((moving[4] + 5.0).abs() < 1e-14);
}

#[test]
fn a_load_case_starts_where_it_says() {
    let model = Arc::new(Model::read_path(frame()).unwrap());
    let initial =
        InitialState { velocity: Some([1.0, 2.0, 3.0]), rates: vec![0.4], ..InitialState::default() };
    let case = LoadCase { initial: Some(initial), ..LoadCase::empty("thrown") };
    let options = Options {
        settings: Settings::default(),
        case: Some(case.clone()),
        points: vec![],
        point_motion: false,
    };
    let mut server = Server::new(&model, options).unwrap();
    hello(&mut server);
    let expected = model.rigid_output(&model.initial_state(&case).unwrap());
    assert_eq!(expected.v_a, [1.0, 2.0, 3.0]);
    for sequence in [1, 3] {
        let start = numbers(server.answer(&request(Kind::Reset, sequence, &[]), host()).unwrap());
        assert_eq!((&start[4..7], &start[10..13]), (&expected.v_g[..], &expected.v_a[..]));
        let moved = numbers(server.answer(&request(Kind::Read, sequence + 1, &[]), host()).unwrap());
        assert_eq!(moved, start);
    }
}

#[test]
fn requests_that_make_no_sense_are_refused_in_words() {
    let (_, mut server) = server(Settings::default());
    hello(&mut server);
    let before = numbers(server.answer(&request(Kind::Read, 1, &[]), host()).unwrap());
    let words = |values: &[u32]| values.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<u8>>();
    let mut nan = step(0, 1, 0, f64::NAN);
    nan = nan[24..nan.len() - 4].to_vec();
    let mut frame = step(0, 1, 0, 0.0)[24..24 + 64].to_vec();
    frame[12..16].copy_from_slice(&99u32.to_le_bytes());
    let mut point = frame.clone();
    point[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    let cases: [(Kind, Vec<u8>, &str); 11] = [
        (Kind::Step, vec![], "at least 8"),
        (Kind::Step, words(&[0, 0]), "0 steps"),
        (Kind::Step, words(&[u32::MAX, 0]), "expected 1 to 1000000"),
        (Kind::Step, words(&[1, u32::MAX]), "4294967295 wrenches"),
        (Kind::Step, nan, "NaN"),
        (Kind::Step, frame, "frame 99"),
        (Kind::Step, point, "point 4294967295"),
        (Kind::Read, words(&[1]), "expected [0]"),
        (Kind::Restore, words(&[3]), "no state was saved"),
        (Kind::Snapshot, words(&[16]), "less than 16"),
        (Kind::Reset, vec![0; 104], "attitude"),
    ];
    for ((kind_asked, payload, part), sequence) in cases.into_iter().zip(2..) {
        let reply = server.answer(&request(kind_asked, sequence, &payload), host()).unwrap();
        assert_eq!(kind(reply), 0xffff, "{part}");
        let message = std::str::from_utf8(&reply[32..reply.len() - 4]).unwrap();
        assert!(message.contains(part), "{message}");
    }
    assert_eq!(numbers(server.answer(&request(Kind::Read, 90, &[]), host()).unwrap()), before);
    assert_eq!((server.counts.refused, server.counts.steps), (11, 0));
}

/// Deterministic noise, and packets that were good before something happened to them: nothing is done, all is counted.
#[test]
fn hostile_packets_are_counted_and_ignored() {
    let (_, mut server) = server(Settings::default());
    hello(&mut server);
    let mut noise = 88172645463325252u64;
    let mut random = move || {
        noise ^= noise << 13;
        noise ^= noise >> 7;
        noise ^= noise << 17;
        noise
    };
    for _ in 0..20_000 {
        let length = random() as usize % 200;
        let mut packet: Vec<u8> = (0..length).map(|_| random() as u8).collect();
        // Half of them begin as they should.
        if random() % 2 == 0 && length >= 8 {
            packet[..8].copy_from_slice(b"ROMU\x01\0\x03\0");
        }
        assert!(server.answer(&packet, host()).is_none());
    }
    let good = step(1, 1, 0, 1.0);
    for length in 0..good.len() {
        assert!(server.answer(&good[..length], host()).is_none(), "cut to {length}");
        let mut flipped = good.clone();
        flipped[length] ^= 1 << (random() % 8);
        assert!(server.answer(&flipped, host()).is_none(), "another bit in byte {length}");
    }
    let mut long = good.clone();
    long.push(0);
    assert!(server.answer(&long, host()).is_none());
    let counts = server.counts;
    assert_eq!((counts.steps, counts.answered), (0, 1));
    assert_eq!(counts.ignored() + counts.answered, counts.received);
    for count in [counts.wrong_length, counts.wrong_magic, counts.wrong_version, counts.wrong_checksum] {
        assert!(count > 0, "{counts:?}");
    }
    // A packet that is whole but no request, and one of another version, both with the right checksum.
    let mut writer = Writer::default();
    writer.begin(99, SESSION, 2);
    assert!(server.answer(writer.finish(), host()).is_none());
    assert_eq!(server.counts.wrong_kind, 1);
    // After all that the server serves.
    assert!(server.answer(&good, host()).is_some());
}

struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[cfg(unix)]
#[test]
fn the_program_serves_until_it_is_interrupted_and_says_what_it_did() {
    let mut command = Command::cargo_bin("romrun").unwrap();
    command.args([text(frame()), "--serve", "udp:0", "--loads", "lc2"]).stdout(Stdio::piped());
    let mut child = Running(command.spawn().unwrap());
    let mut out = BufReader::new(child.0.stdout.take().unwrap());
    let mut line = String::new();
    out.read_line(&mut line).unwrap();
    let place = line.split("udp:").nth(1).unwrap().split(',').next().unwrap();
    let place: SocketAddr = place.parse().unwrap_or_else(|_| panic!("{line}"));
    assert!(place.ip().is_loopback());

    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.connect(place).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    socket.send(b"not for you").unwrap();
    let mut buffer = vec![0; 65536];
    let mut last = Vec::new();
    for packet in [request(Kind::Hello, 0, &[]), step(1, 1000, 0, 0.0), request(Kind::Read, 2, &[])] {
        socket.send(&packet).unwrap();
        let length = socket.recv(&mut buffer).unwrap();
        last = numbers(&buffer[..length]);
    }
    assert!((last[0] - 10.0).abs() < 1e-12);
    // lc2 acts: w_y of the published curve is not zero at its end.
    assert!(last[8].abs() > 1e-3);

    let id = child.0.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let mut words = String::new();
    out.read_to_string(&mut words).unwrap();
    assert_eq!(child.0.wait().unwrap().code(), Some(0), "{words}");
    for part in ["4 packets, 3 answered", "1000 steps", "ignored, wrong length: 1", "median"] {
        assert!(words.contains(part), "{part}: {words}");
    }
}

#[test]
fn wrong_options_are_refused() {
    let file = text(frame());
    for (arguments, part) in [
        (&["--serve", "tcp:1"][..], "udp:ADDRESS:PORT"),
        (&["--serve", "udp:0", "--t-end", "1"], "cannot be used with"),
        (&["--serve", "udp:0", "--loads", "lc1,lc2"], "one load case"),
        (&["--serve", "udp:0", "--dt=-1"], "time step"),
        (&["--serve", "udp:0", "--points", "nowhere"], "nowhere"),
        (&["--serve", "udp:192.0.2.1:0"], "192.0.2.1"),
    ] {
        let all: Vec<&str> = std::iter::once(file).chain(arguments.iter().copied()).collect();
        assert!(refused(romrun(&all), 2).contains(part), "{arguments:?}");
    }
}

/// Counts what a thread allocates.
struct Counting;

thread_local! {
    static ALLOCATIONS: std::cell::Cell<usize> = const { std::cell::Cell::new(0) };
}

// SAFETY: forwards to the system allocator; counting does not touch memory it hands out.
#[allow(unsafe_code)]
unsafe impl std::alloc::GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: std::alloc::Layout) -> *mut u8 {
        // Fails only while a thread ends.
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        unsafe { std::alloc::System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: std::alloc::Layout) {
        unsafe { std::alloc::System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_packet_allocates_nothing() {
    let (_, mut server) = server(Settings::default());
    hello(&mut server);
    let slot = 3u32.to_le_bytes();
    let mut packets: Vec<Vec<u8>> = vec![
        step(1, 10, 0, 5.0),
        request(Kind::Read, 2, &[]),
        request(Kind::Snapshot, 3, &slot),
        step(4, 10, 1, -5.0),
        request(Kind::Restore, 5, &slot),
        request(Kind::Reset, 6, &[]),
        step(7, 1, 0, 5.0),
        request(Kind::Name, 8, &[0; 8]),
        b"noise".to_vec(),
        step(1, 1, 0, 0.0),
    ];
    packets.push(packets[0][..40].to_vec());
    let before = ALLOCATIONS.with(std::cell::Cell::get);
    let answered = packets.iter().filter(|packet| server.answer(packet, host()).is_some()).count();
    assert_eq!(ALLOCATIONS.with(std::cell::Cell::get), before);
    assert_eq!((answered, server.counts.refused), (8, 0));
}
