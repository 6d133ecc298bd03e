use super::*;

/// Values that lose something in careless writing: tiny, huge, negative zero, not exactly decimal.
fn sample() -> Results {
    let mut results = Results::new(Map::from_iter([("load_case".to_owned(), Value::from("lc2"))]));
    let t = results.add(&ChannelSpec::from(MOTION[0]), 3);
    let r = results.add(&ChannelSpec::from(MOTION[1]), 3);
    let q = results.add(&ChannelSpec::modal(&[1, 4]), 3);
    let p = results.add(&point_channels("tip, \"left\"")[0], 3);
    for i in 0..3 {
        let x = f64::from(i);
        results.push(t, &[0.1 * x]);
        results.push(r, &[1.0 / 3.0 * x, -0.0, 1e300 * x]);
        results.push(q, &[f64::MIN_POSITIVE * x, f64::EPSILON]);
        results.push(p, &[x, -x, x * x]);
    }
    results
}

#[test]
fn npz_reads_back_to_the_bit_and_is_the_same_file_every_time() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a.npz"), folder.path().join("b.npz"));
    let results = sample();
    results.write_npz(&a).unwrap();
    results.write_npz(&b).unwrap();
    assert_eq!(std::fs::read(&a).unwrap(), std::fs::read(&b).unwrap());
    let read = Results::read_npz(&a).unwrap();
    assert_eq!(read, results);
    let bits = |r: &Results| {
        r.channels().iter().flat_map(|c| c.data.iter().map(|v| v.to_bits())).collect::<Vec<_>>()
    };
    assert_eq!(bits(&read), bits(&results));
}

#[test]
fn csv_has_the_same_names_and_reads_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.csv");
    let results = sample();
    results.write_csv(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next().unwrap(),
        "t,r_G.x,r_G.y,r_G.z,q.1,q.4,\"tip, \"\"left\"\".dR_A.x\",\"tip, \"\"left\"\".dR_A.y\",\"tip, \"\"left\"\".dR_A.z\""
    );
    for (i, line) in lines.enumerate() {
        let read: Vec<u64> = line.split(',').map(|v| v.parse::<f64>().unwrap().to_bits()).collect();
        let want: Vec<u64> = results.channels().iter().flat_map(|c| c.row(i)).map(|v| v.to_bits()).collect();
        assert_eq!(read, want, "row {i}");
    }
}

#[test]
fn reading_something_else_is_an_error_that_names_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("not.npz");
    std::fs::write(&path, "hello").unwrap();
    let message = Results::read_npz(&path).unwrap_err().to_string();
    assert!(message.contains("not.npz"), "{message}");
}
