"""The draw tool in a real window, driven by mouse and keys."""


def test_draw_edit_undo_and_leave_on_suzanne(window):
    told = window.run("draw")
    assert told["message"] == ""
    assert told["clicked"] == 3
    assert told["shown"] > 4
    assert told["data_while_drawing"], "something was created before Enter"
    assert told["dragged_by"] <= 2  # pixels off the mouse
    assert told["line_moved"]
    assert told["undone_drag"]
    assert (told["undone_click"], told["redone_click"]) == (2, 3)
    assert (told["inserted"], told["removed"], told["closed"]) == (4, 3, True)
    assert told["kept_filter"] == "GEODESIC"
    assert told["kept_points"] > 4
    assert told["edited"] == 3
    assert (told["edited_filter"], told["curves_after_edit"]) == ("LINEAR", 1)
    assert told["filter_after_undo"] == "GEODESIC"
    assert told["curves_after_undo"] == 0
    assert told["drawing_again"] == 1
    assert told["after_esc"] == [0, 0, 0]
    assert (told["in_edit_mode"], told["mode"]) == (1, "EDIT_MESH")
    assert told["with_mirror"] == 3
    assert told["mirrored_apart"] < 1e-5
    assert abs(told["mirrored_ends"][0]) > 0.2


def test_a_million_triangles(window):
    told = window.run("dense")
    print(told)  # times are told, not judged: machines differ
    assert told["triangles"] > 1_000_000
    assert told["message"] == ""
    assert told["picks"] == 4
    assert told["points"] > 300
    assert told["updates"] >= 10, "the line was not made again for most of the mouse's moves"
    assert told["objects"] == 1
