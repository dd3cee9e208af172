/* SPDX-License-Identifier: Apache-2.0
   Moves a focus along a circle for two seconds: cc move_a_focus.c -lhaptogram -lm && ./a.out [PORT] */
#include <haptogram.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static void check(haptogram_code code) {
    if (code == HAPTOGRAM_OK) return;
    fprintf(stderr, "%s\n", haptogram_error());
    exit((int)code);
}

int main(int argc, char** argv) {
    const haptogram_focus middle = {0.0, 0.0, 0.15, 1.0};
    haptogram_image* image;
    check(haptogram_compile_path(&(haptogram_path){sizeof(haptogram_path), .array = "tile-10x10", .board = "tile-100-wide", .foci = &middle, .steps = 1, .board_computes = 1}, &image));
    haptogram_board* board;
    check(haptogram_open(&(haptogram_port){sizeof(haptogram_port), .port = argc > 1 ? argv[1] : "reference:tile-100-wide"}, &board));
    check(haptogram_upload(board, image));
    haptogram_free_image(image);
    check(haptogram_play_live(board, NULL));
    for (int i = 0; i < 2000; ++i) {
        check(haptogram_set_focus(board, 0.02 * cos(0.05 * i), 0.02 * sin(0.05 * i), 0.15, 1.0));
        check(haptogram_wait(board, 1, NULL)); /* a millisecond, unless it has ended */
    }
    haptogram_status status = {.size = sizeof status};
    if (haptogram_get_status(board, &status) == HAPTOGRAM_OK) printf("%llu foci\n", (unsigned long long)status.foci_sent);
    haptogram_close(board); /* which turns the outputs off */
}
