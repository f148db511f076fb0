"""Esc ends long operators in a real window, and timers and the Properties editor may start them."""


def test_esc_timers_and_the_properties_editor(window):
    window.leave_to_the_newest()
    told = window.run("stopped")
    print(told)
    for name in ("add", "seam", "net"):
        assert told[f"{name}_begun"] == [["RUNNING_MODAL"], 1], name
        assert told[f"{name}_ended_by"] == "ESC"
        # Of the 0.2 seconds nothing is the operator's, which never keeps the window waiting; the rest is its drawing.
        assert told[f"{name}_took"] < 0.1, name
        assert told[f"{name}_after_esc"] < 0.2 + 2 * told[f"{name}_pace"], name
        assert told[f"{name}_unchanged"], name
    assert (told["made"], told["last"]) == (1, "MESH_OT_smooth_polyline_add")
    assert (told["after_undo"], told["after_redo"]) == (0, 1)
    assert (told["panel"], told["picks"], told["hidden"], told["shown"]) == (True, 2, True, True)
    assert told["update_in_timer"][0] == ["FINISHED"]
    assert told["made_in_timer"] == [["FINISHED"]] * 3
