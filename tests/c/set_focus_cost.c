/* SPDX-License-Identifier: Apache-2.0
   Prints the median and the longest time of a million calls of haptogram_set_focus, microseconds of the calling thread, while a focus is live. */
#define _POSIX_C_SOURCE 200809L
#include <haptogram.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { calls = 1000000 };
static double taken[calls];

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e6 * (double)t.tv_sec + 1e-3 * (double)t.tv_nsec;
}

static void check(haptogram_code code) {
    if (code == HAPTOGRAM_OK) return;
    fprintf(stderr, "%s\n", haptogram_error());
    exit((int)code);
}

static int order(const void* a, const void* b) {
    const double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

int main(void) {
    const haptogram_focus middle = {0.0, 0.0, 0.15, 1.0};
    const haptogram_path path = {
        .size = sizeof path, .board = "tile-100-wide", .array = "tile-10x10", .foci = &middle, .steps = 1, .board_computes = 1};
    const haptogram_port port = {.size = sizeof port, .port = "reference:tile-100-wide"};
    haptogram_image* image;
    haptogram_board* board;
    check(haptogram_compile_path(&path, &image));
    check(haptogram_open(&port, &board));
    check(haptogram_upload(board, image));
    check(haptogram_play_live(board, NULL));
    for (int i = 0; i < calls; ++i) {
        const double before = now();
        check(haptogram_set_focus(board, 1e-8 * i, 0.0, 0.15, 1.0));
        taken[i] = now() - before;
    }
    qsort(taken, calls, sizeof *taken, order);
    printf("%.3f %.1f\n", taken[calls / 2], taken[calls - 1]);
    haptogram_close(board);
    haptogram_free_image(image);
    return 0;
}
