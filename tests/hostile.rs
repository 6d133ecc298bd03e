//! Input made to break the readers: what a mutating fuzzer would feed them, on the stable toolchain and with the same cases every time.
//!
//! Each target starts from a corpus of sound files, changes them a few times and hands them over. What comes back is a value or an
//! error in words; never a panic, a hang, or a model that makes the runtime give up otherwise than by an error. `ROM_FUZZ_SECONDS`
//! says for how long each target goes on (`.ci/long`: half an hour); a failure names its case, which `ROM_FUZZ_CASE` runs alone.

mod fuzz;

use std::net::SocketAddr;
use std::sync::Arc;

use fuzz::{Random, fuzz};
use rom_cli::serve::{self, Server};
use rom_generator::build::{BuildOptions, ModeSelection, build};
use rom_generator::input::{self, PointTable, Structure};
use rom_runtime::{Model, Settings, Simulation};

const STRUCTURES: [&str; 3] = [
    include_str!("../models/fmb.toml"),
    include_str!("../models/ffb.toml"),
    "[structure]\nname = \"t\"\nreference = \"a\"\n[sections.s]\nshape = \"constants\"\nEA = 1e6\nGAy = 1e6\nGAz = 1e6\nGJ = 1e3\n\
     EIy = 1e3\nEIz = 1e3\nrhoA = 1\nrhoJ = [0.1, 0.05, 0.05]\n[points]\na = [0, 0, 0]\nb = [1, 2, 0]\nc = [3, 0, 1]\n\
     d = { linked_to = \"b\", offset = [0, 0, 1] }\n[[members]]\nname = \"m\"\npath = [\"a\", \"b\", \"c\"]\nsection = [\"s\", \"s\"]\n\
     elements = 4\nlocal_y = [0, 0, 1]\ntwist = [0, 0.3]\n[[masses]]\npoint = \"d\"\nmass = 2\n[gravity]\nacceleration = [0, 0, -9.81]\n\
     [sensors.imu]\npoint = \"d\"\n[load_cases.g]\nt_end = 1\ndt = 0.1\nloads = [{ point = \"c\", frame = \"follower\", force = [0, 0, 1], \
     time = { shape = \"sine\", omega = 3 } }]\n",
];

const LOADS: [&str; 2] = [
    include_str!("../models/gust.toml"),
    "[parameters]\ng = 2\n[times.f]\nexpression = \"g*sin(t) + vx\"\n[load_cases.a]\nt_end = 1\ndt = 0.01\n\
     loads = [{ point = \"P\", frame = \"dead\", force = [1, 2, 3], time = \"f\" }]\n",
];

/// Pieces that mean something to a reader of TOML, of expressions or of numbers.
const TOKENS: [&str; 40] = [
    "0",
    "-1",
    "1e308",
    "1e-308",
    "nan",
    "inf",
    "-0.0",
    "9223372036854775807",
    "\"",
    "'",
    "\"\"\"",
    "[",
    "]",
    "[[",
    "{",
    "}",
    "=",
    ",",
    ".",
    "#",
    "\n",
    "\u{0}",
    "\u{feff}",
    "é",
    "\"1/0\"",
    "\"sqrt(-1)\"",
    "\"((((\"",
    "\"a^b\"",
    "t",
    "vx",
    "true",
    "1979-05-27",
    "0x1f",
    "\\u0000",
    "elements",
    "name",
    "[points]",
    "[structure]",
    "[load_cases.x]",
    "[0, 0, 0]",
];

fn mutated_text(source: &str, random: &mut Random) -> String {
    let mut text: Vec<char> = source.chars().collect();
    for _ in 0..1 + random.below(6) {
        let n = text.len();
        let at = random.below(n + 1);
        let token: Vec<char> = random.of(&TOKENS).chars().collect();
        match random.below(6) {
            0 => drop(text.splice(at..at, token)),
            1 => {
                let end = (at + 1 + random.below(12)).min(n);
                drop(text.splice(at.min(end)..end, token));
            }
            2 => drop(text.drain(at..(at + random.below(40)).min(n).max(at))),
            3 => {
                // A piece again elsewhere.
                let end = (at + random.below(80)).min(n);
                let piece = text[at.min(end)..end].to_vec();
                let to = random.below(n + 1);
                drop(text.splice(to..to, piece));
            }
            4 if at < n => text[at] = char::from(random.next() as u8),
            _ => {
                // A number for another.
                let digit = (at..n).find(|&i| text[i].is_ascii_digit());
                if let Some(digit) = digit {
                    let number = format!("{:e}", f64::from_bits(random.next()));
                    drop(text.splice(digit..=digit, number.chars()));
                }
            }
        }
    }
    text.into_iter().collect()
}

fn has_reasons(errors: &input::InputErrors) {
    assert!(errors.iter().count() > 0 && errors.iter().all(|e| !e.message().is_empty()));
}

/// Whatever is read without an error is built too, where it is small: a model or a reason.
#[test]
fn structure_files() {
    fuzz("structure files", |random| {
        let source: &&str = random.of(&STRUCTURES);
        let text = mutated_text(source, random);
        match Structure::from_toml_str(&text, "hostile.toml", &[]) {
            Err(errors) => has_reasons(&errors),
            Ok(structure) if structure.element_count() <= 200 => {
                let options = BuildOptions {
                    modes: ModeSelection::Count(random.below(4)),
                    all_nodes: false,
                    ..BuildOptions::default()
                };
                match build(&structure, &options, &mut |_| ()) {
                    Ok(data) => march(Model::new(data).expect("the runtime takes what the generator makes")),
                    Err(reason) => assert!(!reason.to_string().is_empty()),
                }
            }
            Ok(_) => {}
        }
    });
}

fn frame() -> rom_runtime::ModelData {
    let sets = [("elements".to_owned(), "12".to_owned())];
    let structure = Structure::from_toml_str(STRUCTURES[0], "frame", &sets).unwrap();
    let options =
        BuildOptions { modes: ModeSelection::Count(3), all_nodes: false, ..BuildOptions::default() };
    build(&structure, &options, &mut |_| ()).unwrap()
}

#[test]
fn load_files() {
    let data = frame();
    let table = PointTable::new(&data.points, &data.lines, &data.provenance.parameters);
    let model = Model::new(data.clone()).unwrap();
    fuzz("load files", |random| {
        let source: &&str = random.of(&LOADS);
        let text = mutated_text(source, random);
        match input::read_load_cases(&text, "hostile.toml", &table, &[]) {
            Err(errors) => has_reasons(&errors),
            Ok(cases) => {
                for case in &cases {
                    // Loads may be beyond what the model can take: then the step says so.
                    if let Ok(loads) = model.prepare(case) {
                        steps(model.clone(), &loads);
                    }
                }
            }
        }
    });
}

const HEADER: usize = 24;
const ENTRY: usize = 24;

fn word(file: &[u8], at: usize) -> usize {
    file.get(at..at + 8).map_or(0, |bytes| u64::from_le_bytes(bytes.try_into().unwrap()) as usize)
}

/// Bytes changed inside the sections, with checksums that agree, so that what is behind them is reached; or anywhere, without.
#[test]
fn model_files() {
    let sound = frame().to_bytes().unwrap();
    let sections = u32::from_le_bytes(sound[12..16].try_into().unwrap()) as usize;
    fuzz("model files", |random| {
        let mut file = sound.clone();
        let sealed = random.below(4) > 0;
        for _ in 0..1 + random.below(4) {
            let entry = HEADER + ENTRY * random.below(sections);
            let (offset, length) = (word(&sound, entry + 8), word(&sound, entry + 16));
            let at = if sealed { offset + random.below(length) } else { random.below(file.len()) };
            let value: Vec<u8> = match random.below(5) {
                0 => vec![random.next() as u8],
                1 => random.next().to_le_bytes().to_vec(),
                2 => random.of(&[0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, -1e-300]).to_le_bytes().to_vec(),
                3 => random.of(&[0_u64, 1, 7, u64::MAX, 1 << 32, 1 << 62]).to_le_bytes().to_vec(),
                _ => file[at..(at + 8).min(file.len())].iter().map(|b| b ^ (1 << random.below(8))).collect(),
            };
            let end = (at + value.len()).min(if sealed { offset + length } else { file.len() });
            file[at..end].copy_from_slice(&value[..end - at]);
        }
        if sealed {
            for i in 0..sections {
                let entry = HEADER + ENTRY * i;
                let (offset, length) = (word(&file, entry + 8), word(&file, entry + 16));
                let checksum = crc32fast::hash(&file[offset..offset + length]);
                file[entry + 4..entry + 8].copy_from_slice(&checksum.to_le_bytes());
            }
            let end = HEADER + ENTRY * sections;
            let checksum = crc32fast::hash(&file[..end]);
            file[end..end + 4].copy_from_slice(&checksum.to_le_bytes());
        }
        match Model::from_bytes(&file) {
            Err(reason) => assert!(!reason.to_string().is_empty()),
            Ok(model) => march(model),
        }
    });
}

/// Packets of strangers: sound ones with any payload, and those damaged on their way, one after the other to one server.
#[test]
fn udp_packets() {
    let model = Arc::new(Model::new(frame()).unwrap());
    let options = serve::Options {
        settings: Settings { dt: 0.01, ..Settings::default() },
        case: model.data().load_cases.first().cloned(),
        points: (0..model.n_points()).collect(),
        point_motion: true,
    };
    let peer: SocketAddr = "127.0.0.1:4000".parse().unwrap();
    let mut server = Server::new(&model, options).unwrap();
    let mut sequence = 0_u32;
    fuzz("UDP packets", |random| {
        // Most requests belong to a session; a case is a conversation.
        for place in 0..1 + random.below(12) {
            sequence = sequence.wrapping_add(1);
            let kind = if place == 0 { 1 } else { random.below(9) as u16 };
            let packet = packet(kind, sequence, &payload(kind, random), random);
            let before = server.counts.received;
            if let Some(reply) = server.answer(&packet, peer) {
                assert!(reply.len() >= HEADER_OF_PACKET && reply.starts_with(b"ROMU"), "a reply is a packet");
            }
            assert_eq!(server.counts.received, before + 1);
        }
    });
    println!("{:?}", server.counts);
    assert!(server.counts.steps > 0 && server.counts.refused > 0 && server.counts.wrong_checksum > 0);
}

const HEADER_OF_PACKET: usize = 24;

fn payload(kind: u16, random: &mut Random) -> Vec<u8> {
    let mut bytes = Vec::new();
    let number = |random: &mut Random| -> f64 {
        match random.below(4) {
            0 => *random.of(&[0.0, 1.0, -1e3, f64::NAN, f64::INFINITY, 1e300, -1e-300]),
            1 => f64::from_bits(random.next()),
            _ => random.below(2_000) as f64 - 1_000.0,
        }
    };
    match kind {
        // Steps: few of them, as many may take as long as they like.
        3 => {
            let wrenches = random.below(4) as u32;
            bytes.extend((random.below(6) as u32).to_le_bytes());
            bytes.extend(wrenches.to_le_bytes());
            for _ in 0..wrenches {
                bytes.extend((random.below(8) as u32).to_le_bytes());
                bytes.extend((random.below(5) as u32).to_le_bytes());
                (0..6).for_each(|_| bytes.extend(number(random).to_le_bytes()));
            }
        }
        // A motion to start with.
        5 if random.below(2) == 0 => (0..13).for_each(|_| bytes.extend(number(random).to_le_bytes())),
        2 | 6 | 7 => {
            (0..1 + random.below(2)).for_each(|_| bytes.extend((random.below(20) as u32).to_le_bytes()))
        }
        _ => {}
    }
    if random.below(6) == 0 {
        bytes.truncate(random.below(bytes.len() + 1));
        // Not where the number of steps stands.
        let tail: Vec<u8> = (0..random.below(9)).map(|_| random.next() as u8).collect();
        if kind != 3 || bytes.len() >= 4 {
            bytes.extend(tail);
        }
    }
    bytes
}

/// A packet as docs/udp.md has it; one in eight is damaged.
fn packet(kind: u16, sequence: u32, payload: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = b"ROMU".to_vec();
    bytes.extend(1_u16.to_le_bytes());
    bytes.extend(kind.to_le_bytes());
    bytes.extend(7_u32.to_le_bytes());
    bytes.extend(sequence.to_le_bytes());
    bytes.extend((payload.len() as u32).to_le_bytes());
    bytes.extend(0_u32.to_le_bytes());
    bytes.extend(payload);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    if random.below(8) == 0 {
        let at = random.below(bytes.len());
        bytes[at] ^= 1 << random.below(8);
        bytes.truncate(bytes.len() - random.below(2) * random.below(bytes.len()));
    }
    bytes
}

/// A few steps of every load case the model has.
fn march(model: Model) {
    let cases = model.data().load_cases.clone();
    for case in cases.iter().take(3) {
        if let Ok(loads) = model.prepare(case) {
            steps(model.clone(), &loads);
        }
    }
}

/// Steps until the end, or until the runtime says that it cannot go on; it never goes on with what is not a number.
fn steps(model: Model, loads: &rom_runtime::PreparedLoads) {
    let Ok(mut simulation) = Simulation::new(model.into(), Settings { dt: 0.01, ..Settings::default() })
    else {
        return;
    };
    if simulation.solve_accelerations(loads).is_err() {
        return;
    }
    for _ in 0..5 {
        if simulation.step(loads).is_err() {
            return;
        }
        let state = simulation.state();
        assert!(
            state.q.iter().chain(&state.q_dot).all(|x| x.is_finite()),
            "a step that succeeds leaves numbers: {:?}",
            state.q
        );
    }
}
