//! `render`: what is behind opaque surfaces.

use crate::{kit::Folder, render::pixels};

#[test]
fn a_surface_behind_another_one_is_not_made_and_that_is_said() {
    let folder = Folder::with_ball();
    let line = "render ball.nii --iso 40:wall:#ff0000 --size 300x300";
    folder.done(&format!("{line} -o alone.png"));
    let ran = folder.done(&format!("{line} --iso 70:core -o both.png -v --report r.json"));
    assert!(ran.err.contains("core not made: it is behind opaque surfaces"), "{}", ran.err);
    let report = folder.json("r.json");
    assert_eq!(report["skipped"]["surfaces"][0]["why"], "it is behind opaque surfaces");
    assert_eq!(report["surfaces"][1]["triangles"], 0);
    assert_eq!(pixels(&folder, "both.png"), pixels(&folder, "alone.png"));
    // Side by side and where a plane cuts it is seen; and depths are those of other points.
    for other in ["--sheet", "--clip 0,1,0,33", "--depth d.png"] {
        folder.done(&format!("{line} --iso 70:core {other} -o both.png --report r.json"));
        let report = folder.json("r.json");
        assert!(report["surfaces"][1]["triangles"].as_u64().unwrap() > 20, "{other}: {report}");
    }
    // A plan reads no sample, and does not know it.
    let ran = folder.done(&format!("{line} --iso 70:core --plan"));
    assert!(ran.text().contains("core: extracted at 70"), "{}", ran.text());
}
