//! The `.rom` file: round trip, and refusal of everything that is not a sound one.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use crate::common::Lumped;
use rom_runtime::data::{LineData, StationSet};
use rom_runtime::expression::{Binary, Instruction, Program, Unary, Variable};
use rom_runtime::format::{MAGIC, VERSION_MAJOR, VERSION_MINOR};
use rom_runtime::time::TimeFunction;
use rom_runtime::{
    DistributedFrame, DistributedLoad, FormatError, Load, LoadCase, LoadFrame, Model, ModelData,
};

/// Remembers the largest single allocation of each thread.
struct Watching;

thread_local! {
    static LARGEST: Cell<usize> = const { Cell::new(0) };
}

fn note(size: usize) {
    // Fails only while a thread ends.
    let _ = LARGEST.try_with(|largest| largest.set(largest.get().max(size)));
}

// SAFETY: forwards to the system allocator; noting a size does not touch memory it hands out.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for Watching {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        note(size);
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Watching = Watching;

/// Largest single allocation while `work` runs.
fn largest_allocation<T>(work: impl FnOnce() -> T) -> (T, usize) {
    LARGEST.with(|largest| largest.set(0));
    let result = work();
    (result, LARGEST.with(Cell::get))
}

/// A small model that uses every kind of value the format has.
fn data() -> ModelData {
    let mut data = Lumped::spring(6.0, 2.0, 40.0).data(1);
    data.points.truncate(2);
    let times = vec![
        TimeFunction::Constant { value: 0.5 },
        TimeFunction::Step { value: 1.0, start: 0.02, end: f64::MAX },
        TimeFunction::Ramp { rate: 2.0, start: 0.0, end: 0.3 },
        TimeFunction::Triangle { peak: 1.0, start: 0.0, at: 0.1, end: 0.2 },
        TimeFunction::Sine { amplitude: 1.0, omega: 5.0, phase: 0.1, start: 0.0, end: 1.0 },
        TimeFunction::OneMinusCosine { amplitude: 1.0, start: 0.0, duration: 0.3 },
        TimeFunction::Table { t: vec![0.0, 0.1], value: vec![0.0, 1.0] },
        TimeFunction::Expression {
            program: Program {
                source: "t + sin(vx)".into(),
                code: vec![
                    Instruction::Variable(Variable::T),
                    Instruction::Variable(Variable::Vx),
                    Instruction::Unary(Unary::Sin),
                    Instruction::Binary(Binary::Add),
                ],
            },
        },
    ];
    let frames = [
        LoadFrame::Dead,
        LoadFrame::Body,
        LoadFrame::Follower { section: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] },
    ];
    let loads = times.into_iter().enumerate().map(|(i, time)| Load {
        point: 1,
        frame: frames[i % 3],
        force: [1.0, 2.0, 3.0],
        moment: [4.0, 5.0, 6.0],
        time,
    });
    let point = data.points[0].clone();
    data.lines = vec![LineData {
        name: "wing".into(),
        length: 2.0,
        knots: vec![0.0, 1.0],
        stations: StationSet {
            position: point.node_position.repeat(3),
            rotation: point.node_rotation.repeat(3),
            phi_translation: point.phi_translation.repeat(3),
            phi_rotation: point.phi_rotation.repeat(3),
        },
    }];
    let lift = DistributedLoad {
        member: 0,
        frame: DistributedFrame::Follower,
        force: vec![1.0; 9],
        moment: vec![],
        time: TimeFunction::Constant { value: 2.0 },
    };
    data.load_cases = vec![LoadCase {
        description: "every time function, µ".into(),
        dt: 0.01,
        numerical_damping: 0.01,
        loads: loads.collect(),
        distributed: vec![lift],
        ..LoadCase::empty("gust")
    }];
    data
}

#[test]
fn a_model_survives_the_round_trip_and_gives_the_same_bytes() {
    for picture in [true, false] {
        let mut data = data();
        if !picture {
            data.picture = None;
        }
        let bytes = data.to_bytes().unwrap();
        assert_eq!(bytes, data.clone().to_bytes().unwrap(), "same data, same bytes");
        let model = Model::from_bytes(&bytes).unwrap();
        assert_eq!(model.data(), &data);
        assert_eq!(model.to_bytes().unwrap(), bytes);
    }
}

#[test]
fn every_truncation_is_refused() {
    let bytes = data().to_bytes().unwrap();
    for length in 0..bytes.len() {
        let (result, largest) = largest_allocation(|| Model::from_bytes(&bytes[..length]));
        assert!(result.is_err(), "cut to {length} bytes");
        assert!(largest < 4096, "cut to {length} bytes: {largest} bytes allocated");
    }
}

#[test]
fn every_flipped_byte_is_refused_before_contents_are_allocated() {
    let bytes = data().to_bytes().unwrap();
    for at in 0..bytes.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] ^= flip;
            let (result, largest) = largest_allocation(|| Model::from_bytes(&damaged));
            let error = match result {
                Ok(_) => panic!("byte {at} flipped by {flip:#x} was accepted"),
                Err(error) => error,
            };
            assert!(
                !matches!(error, FormatError::Decode { .. } | FormatError::Model(_)),
                "byte {at}: {error}"
            );
            assert!(largest < 4096, "byte {at}: {largest} bytes allocated");
        }
    }
}

#[test]
fn what_follows_the_file_is_refused() {
    let mut bytes = data().to_bytes().unwrap();
    bytes.push(0);
    assert!(matches!(Model::from_bytes(&bytes), Err(FormatError::Length { what: "the file", .. })));
    // Also when the header counts it in.
    let length = bytes.len() as u64;
    bytes[16..24].copy_from_slice(&length.to_le_bytes());
    seal(&mut bytes);
    let error = Model::from_bytes(&bytes).unwrap_err();
    assert!(error.to_string().contains("follows the last section"), "{error}");
}

const HEADER: usize = 24;
const ENTRY: usize = 24;

fn n_sections(file: &[u8]) -> usize {
    u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize
}

/// Recomputes the checksum of header and table.
fn seal(file: &mut [u8]) {
    let end = HEADER + n_sections(file) * ENTRY;
    let checksum = crc32fast::hash(&file[..end]);
    file[end..end + 4].copy_from_slice(&checksum.to_le_bytes());
}

/// Puts a file together from sections, with all checksums right.
fn assemble(sections: &[([u8; 4], Vec<u8>)]) -> Vec<u8> {
    let mut file = MAGIC.to_vec();
    file.extend(VERSION_MAJOR.to_le_bytes());
    file.extend(VERSION_MINOR.to_le_bytes());
    file.extend((sections.len() as u32).to_le_bytes());
    let first = HEADER + sections.len() * ENTRY + 4;
    let length = first + sections.iter().map(|section| section.1.len()).sum::<usize>();
    file.extend((length as u64).to_le_bytes());
    let mut offset = first as u64;
    for (name, bytes) in sections {
        file.extend(name);
        file.extend(crc32fast::hash(bytes).to_le_bytes());
        file.extend(offset.to_le_bytes());
        file.extend((bytes.len() as u64).to_le_bytes());
        offset += bytes.len() as u64;
    }
    file.extend(crc32fast::hash(&file).to_le_bytes());
    for (_, bytes) in sections {
        file.extend(bytes);
    }
    file
}

fn take_apart(file: &[u8]) -> Vec<([u8; 4], Vec<u8>)> {
    (0..n_sections(file))
        .map(|i| {
            let entry = &file[HEADER + i * ENTRY..][..ENTRY];
            let number = |at: usize| u64::from_le_bytes(entry[at..at + 8].try_into().unwrap()) as usize;
            (entry[..4].try_into().unwrap(), file[number(8)..][..number(16)].to_vec())
        })
        .collect()
}

#[test]
fn the_file_is_laid_out_as_documented() {
    let bytes = data().to_bytes().unwrap();
    assert_eq!(assemble(&take_apart(&bytes)), bytes);
    let names: Vec<_> = take_apart(&bytes).into_iter().map(|section| section.0).collect();
    let expected = ["PROV", "RIGI", "MODE", "TENC", "TENK", "PNTS", "LOAD", "CHEK", "PICT", "LINE"];
    assert_eq!(names, expected.map(|name| <[u8; 4]>::try_from(name.as_bytes()).unwrap()));
    // The example of docs/rom-format.md: RIGI starts with the mass and the centre of mass.
    let rigid = &take_apart(&bytes)[1].1;
    assert_eq!(rigid[..8], data().rigid.mass.to_le_bytes());
    assert_eq!(rigid[8..16], data().rigid.centre_of_mass[0].to_le_bytes());
    assert_eq!(rigid[32..40], 36_u64.to_le_bytes());
    assert_eq!(rigid.len(), 8 + 24 + 8 + 36 * 8 + 24);
}

#[test]
fn newer_versions_are_told_apart() {
    let bytes = data().to_bytes().unwrap();
    let mut newer = bytes.clone();
    newer[8..10].copy_from_slice(&(VERSION_MAJOR + 1).to_le_bytes());
    seal(&mut newer);
    let error = Model::from_bytes(&newer).unwrap_err();
    assert!(matches!(error, FormatError::Version { .. }));
    let message = error.to_string();
    for part in ["2.0", "1.x", "newer program", "structure file"] {
        assert!(message.contains(part), "{message}");
    }
    // A newer minor version, with a section this program does not know.
    let mut sections = take_apart(&bytes);
    sections.insert(2, (*b"NEWS", vec![1, 2, 3]));
    let mut minor = assemble(&sections);
    minor[10..12].copy_from_slice(&(VERSION_MINOR + 7).to_le_bytes());
    seal(&mut minor);
    assert_eq!(Model::from_bytes(&minor).unwrap().data(), &data());
    // Unknown or not, its bytes are checked.
    let at = minor.windows(3).position(|window| window == [1, 2, 3]).unwrap();
    minor[at] = 9;
    let error = Model::from_bytes(&minor).unwrap_err();
    assert!(matches!(error, FormatError::Checksum { .. }) && error.to_string().contains("NEWS"), "{error}");
}

#[test]
fn other_files_are_named_as_such() {
    for other in
        [&b""[..], b"ROM", b"[structure]\nname = \"FMB\"\n", b"\x89PNG\r\n\x1a\n....................."]
    {
        let error = Model::from_bytes(other).unwrap_err();
        assert!(matches!(error, FormatError::Magic { .. }), "{error}");
    }
    // A transfer that turns line ends.
    let text: Vec<u8> = String::from_utf8_lossy(&MAGIC).replace("\r\n", "\n").into_bytes();
    assert!(matches!(Model::from_bytes(&text), Err(FormatError::Magic { .. })));
}

#[test]
fn malformed_tables_are_refused() {
    let sections = take_apart(&data().to_bytes().unwrap());
    for missing in 0..sections.len() {
        let mut rest = sections.clone();
        let (name, _) = rest.remove(missing);
        let result = Model::from_bytes(&assemble(&rest));
        if &name == b"PICT" {
            assert!(result.is_ok(), "pictures are optional");
        } else if &name == b"LINE" {
            // Optional, but a load case of this model is distributed along one of its members.
            assert!(result.unwrap_err().to_string().contains("distributed load"));
        } else {
            let error = result.unwrap_err();
            assert!(matches!(error, FormatError::Missing { section } if section.0 == name), "{error}");
        }
    }
    let mut twice = sections.clone();
    twice.push(sections[1].clone());
    assert!(Model::from_bytes(&assemble(&twice)).unwrap_err().to_string().contains("twice"));

    let file = assemble(&sections);
    // Overlapping, far away, too long, more sections than bytes.
    let entry = HEADER + ENTRY;
    for (at, value) in
        [(entry + 8, HEADER as u64), (entry + 8, u64::MAX), (entry + 16, u64::MAX), (entry + 16, 1 << 40)]
    {
        let mut bad = file.clone();
        bad[at..at + 8].copy_from_slice(&value.to_le_bytes());
        seal(&mut bad);
        let (result, largest) = largest_allocation(|| Model::from_bytes(&bad));
        let error = result.unwrap_err();
        assert!(matches!(error, FormatError::Table { .. } | FormatError::Length { .. }), "{error}");
        assert!(largest < 4096);
    }
    let mut many = file.clone();
    many[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(matches!(Model::from_bytes(&many), Err(FormatError::Length { .. })));
}

/// Overwrites eight bytes at every offset of a section, with sound checksums around.
#[test]
fn hostile_lengths_inside_sections_cannot_allocate() {
    hostile_lengths(&take_apart(&data().to_bytes().unwrap()), 1, |_| true);
    // The sections of a consistent model.
    let consistent = crate::common::lagrangian::bent(false).1;
    hostile_lengths(&take_apart(&consistent.to_bytes().unwrap()), 5, |name| {
        [b"LAGR", b"PCUR"].contains(&name)
    });
}

/// At every `step`-th offset.
fn hostile_lengths(sections: &[([u8; 4], Vec<u8>)], step: usize, among: impl Fn(&[u8; 4]) -> bool) {
    assert!(sections.iter().any(|(name, _)| among(name)));
    for (index, (name, bytes)) in sections.iter().enumerate().filter(|(_, (name, _))| among(name)) {
        for at in (0..bytes.len().saturating_sub(7)).step_by(step) {
            for value in [u64::MAX, 1 << 40, 1 << 20, 0] {
                let mut hostile = sections.to_vec();
                hostile[index].1[at..at + 8].copy_from_slice(&value.to_le_bytes());
                let file = assemble(&hostile);
                // Ok, or an error; never a panic or a large allocation (serde reserves up to 1 MiB on trust).
                let (_, largest) = largest_allocation(|| drop(Model::from_bytes(&file)));
                assert!(largest <= 1 << 20, "{}, byte {at}: {largest} bytes", name.escape_ascii());
            }
        }
        let mut longer = sections.to_vec();
        longer[index].1.push(0);
        let error = Model::from_bytes(&assemble(&longer)).unwrap_err();
        assert!(matches!(error, FormatError::Decode { .. }), "{error}");
        let mut shorter = sections.to_vec();
        shorter[index].1.pop();
        let error = Model::from_bytes(&assemble(&shorter)).unwrap_err();
        assert!(matches!(error, FormatError::Decode { .. }), "{error}");
    }
}

#[test]
fn files_are_written_atomically_and_errors_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.rom");
    let data = data();
    data.write_path(&path).unwrap();
    assert_eq!(Model::read_path(&path).unwrap().data(), &data);
    // Written over, and nothing else is left in the folder.
    Model::new(data.clone()).unwrap().write_path(&path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), data.to_bytes().unwrap());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

    let missing = folder.path().join("missing.rom");
    let message = Model::read_path(&missing).unwrap_err().to_string();
    assert!(message.contains("missing.rom") && message.contains("open"), "{message}");
    let nowhere = folder.path().join("no folder").join("model.rom");
    assert!(data.write_path(&nowhere).unwrap_err().to_string().contains("no folder"));
    // A failed write leaves the old file.
    assert!(data.write_path(folder.path()).is_err());
    assert!(path.exists());

    let text = folder.path().join("fmb.toml");
    std::fs::write(&text, "[structure]\nname = \"FMB\"\n").unwrap();
    let message = Model::read_path(&text).unwrap_err().to_string();
    assert!(message.contains("fmb.toml") && message.contains("not a .rom model file"), "{message}");
    let short = folder.path().join("short.rom");
    let bytes = data.to_bytes().unwrap();
    std::fs::write(&short, &bytes[..bytes.len() - 1]).unwrap();
    let message = Model::read_path(&short).unwrap_err().to_string();
    assert!(message.contains("short.rom") && message.contains(&format!("{}", bytes.len())), "{message}");
    assert!(Model::read_path(folder.path()).is_err(), "a folder");
}

#[cfg(unix)]
#[test]
fn a_model_file_has_ordinary_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (model, plain) = (folder.path().join("model.rom"), folder.path().join("plain"));
    data().write_path(&model).unwrap();
    std::fs::write(&plain, "").unwrap();
    let mode = |path| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&model), mode(&plain));
}
