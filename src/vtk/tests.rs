use super::*;

#[test]
fn a_grid_is_well_formed_whatever_its_fields_are_called() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vtu");
    let field = Field { name: "<\"mode\" & co>".to_owned(), values: vec![1.0; 6] };
    let grid = Grid {
        points: vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        lines: vec![vec![0, 1]],
        fields: vec![field],
        cell_fields: Vec::new(),
    };
    grid.write(&path).unwrap();
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains(r#"NumberOfPoints="2" NumberOfCells="1""#), "{text}");
    assert!(text.contains(r#"Name="&lt;&quot;mode&quot; &amp; co&gt;""#), "{text}");
    // 48 bytes of points: their number as u64, then themselves, each with its own padding.
    assert!(text.contains(">MAAAAAAAAAA=AAAAAAAAAAA"), "{text}");
}
