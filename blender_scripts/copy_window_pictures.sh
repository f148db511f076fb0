#!/usr/bin/env bash
# Takes the docs' pictures of the draw tool from what the window tests have left in out/gui: copy_window_pictures.sh
# Holds no test and starts nothing; `make images-gui` runs the tests first.
set -euo pipefail
cd "$(dirname "$0")/.."

while read -r shot picture; do
    for blender in own sid trixie; do
        if [ -e "out/gui/$blender-$shot.png" ]; then
            cp "out/gui/$blender-$shot.png" "docs/images/$picture.png"
            continue 2
        fi
    done
    echo "out/gui has no $shot; run make test-gui"
    exit 1
done <<END
trial-3_turned_by_mouse draw_parting
trial-5_loop draw_loop
trial-6_detail_size draw_detail_size
trial-7_cubic_dragged drawing
trial-10_edited_again draw_edit_again
pose-1_drawn follow_rest
pose-2_frame_20 follow_pose
pose-3_mirrored draw_mirrored
END
