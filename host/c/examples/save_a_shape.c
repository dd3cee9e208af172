/* SPDX-License-Identifier: Apache-2.0
   Writes the image of a dome, and prints the sound on a line above it: cc save_a_shape.c -lhaptogram && ./a.out [dome.hex] */
#include <haptogram.h>
#include <stdio.h>

static const char dome[] =
    "format = \"haptogram-project-1\"\n"
    "points = 60\n"
    "[[shape]]\n"
    "kind = \"hemisphere\"\n"
    "diameter_mm = 50\n"
    "center_mm = [0, 0, 150]\n";

int main(int argc, char** argv) {
    haptogram_image* image;
    double points_m[5][3], pressure_pa[5];
    for (int i = 0; i < 5; ++i) points_m[i][0] = points_m[i][1] = 0.0, points_m[i][2] = 0.15 + 0.01 * i;
    haptogram_code code = haptogram_compile(&(haptogram_project){sizeof(haptogram_project), .toml = dome}, &image);
    if (code == HAPTOGRAM_OK) {
        code = haptogram_pressure(image, 0, points_m[0], 5, pressure_pa);
        for (int i = 0; code == HAPTOGRAM_OK && i < 5; ++i) printf("%.0f mm: %.0f Pa\n", 1e3 * points_m[i][2], pressure_pa[i]);
        if (code == HAPTOGRAM_OK) code = haptogram_save_image(image, argc > 1 ? argv[1] : "dome.hex");
        haptogram_free_image(image);
    }
    if (code != HAPTOGRAM_OK) fprintf(stderr, "%s\n", haptogram_error());
    return code;
}
