"""Put Lines into Mesh in a real window: picks by clicks, search, the panel of the last operation, undo."""


def test_a_seam_from_clicks_to_undo(window):
    told = window.run("seam")
    assert told["picked"] == told["picked_after_undo"] == 3
    before = told["before_vertices"]
    assert told["before_seams"] == told["undone_seams"] == 0
    assert told["cut_vertices"] > before + 3
    assert told["cut_seams"] > 3
    assert told["redo_snap_vertices"] == told["redo_slide_vertices"] == before
    assert told["redo_snap_seams"] == told["redo_slide_seams"] > 2
    assert told["redo_snap_places"] == told["before_places"] != told["redo_slide_places"]
    assert (told["redo_cut_vertices"], told["redo_cut_seams"]) == (told["cut_vertices"], told["cut_seams"])
    assert told["told"].startswith("Island 1: ")
    assert told["undone_vertices"] == before
    assert (told["redone_vertices"], told["redone_seams"]) == (told["cut_vertices"], told["cut_seams"])
