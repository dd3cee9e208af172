/* SPDX-License-Identifier: Apache-2.0
   Haptogram for other languages: compile shapes, compute fields, drive a board. Plain C.

   Lengths are metres in the array's frame: x right, y forward, z up from the transducers, right-handed. Text is UTF-8.
   A function that can fail returns a haptogram_code. After one that is not HAPTOGRAM_OK, haptogram_error() says in words what is
   wrong, in this thread, until its next call. Nothing calls back, and no exception leaves the library. Every struct begins with
   its size, which the caller sets, so that later versions can append to it; what the caller leaves zero has its default.

   A board has a thread of its own in the library, which connects again after a loss. Functions of a board may be called from
   any thread. haptogram_set_focus never waits. Closing a board turns its outputs off, and so does the end of the program
   by return from main, exit or quick_exit. On Windows only closing does, on macOS not quick_exit. If the program ends in
   another way (it is killed, it aborts, as C# does after an exception that nobody catches), the board's watchdog does. */
#ifndef HAPTOGRAM_H
#define HAPTOGRAM_H
#include <stddef.h>
#include <stdint.h>
#if defined _WIN32 && defined HAPTOGRAM_INSIDE
#define HAPTOGRAM_API __declspec(dllexport)
#elif defined _WIN32
#define HAPTOGRAM_API __declspec(dllimport)
#else
#define HAPTOGRAM_API __attribute__((visibility("default")))
#endif
#ifdef __cplusplus
extern "C" {
#endif

/* Goes up when something that was there changes; haptogram_abi() is the library's. */
#define HAPTOGRAM_ABI 1

typedef struct haptogram_board haptogram_board; /* an open port */
typedef struct haptogram_link haptogram_link;   /* a port that is asked by the protocol's own commands */
typedef struct haptogram_image haptogram_image; /* the contents of a board's memories, and what they mean */
typedef struct haptogram_array haptogram_array; /* transducers that play together, and the air in front of them; it never changes */
typedef struct haptogram_result haptogram_result; /* what was computed: numbers, and JSON that says what they are */

typedef enum haptogram_code {
    HAPTOGRAM_OK = 0,
    HAPTOGRAM_FAILED = 1,       /* the result is not good */
    HAPTOGRAM_BAD_ARGUMENT = 2, /* what the caller asked for makes no sense */
    HAPTOGRAM_BAD_INPUT = 3,    /* a file, a text, or an image that does not suit the board */
    HAPTOGRAM_DEVICE = 4,       /* the board, or the line to it */
    HAPTOGRAM_CANCELLED = 5     /* the outputs were shut off, or this work was cancelled */
} haptogram_code;

HAPTOGRAM_API int32_t haptogram_abi(void);
HAPTOGRAM_API const char* haptogram_version(void);
HAPTOGRAM_API const char* haptogram_error(void);
/* The place of the last error, with which its words begin: a file, a setting, a port, a command; may be empty. */
HAPTOGRAM_API const char* haptogram_error_place(void);
/* The settings that could mend the last error, as a project file calls them, separated by commas; may be empty. */
HAPTOGRAM_API const char* haptogram_remedies(void);

/* Images. */

typedef struct haptogram_project {
    uint32_t size;
    const char* toml;   /* the text of a project file; needed without `file` */
    const char* folder; /* where names in it begin; default: the working folder */
    const char* shape_name; /* the `file` of one of its shapes that is not read, because its bytes are here; default: none */
    const void* shape;
    size_t shape_bytes;
    const char* name; /* of the text, for messages; default: "project" */
    const char* file; /* a project file instead of the text */
    const int32_t* cancel; /* the work ends as cancelled when another thread makes this other than 0; default: it does not */
} haptogram_project;
HAPTOGRAM_API haptogram_code haptogram_compile(const haptogram_project* project, haptogram_image** image);

/* For a rig, a file or a shipped one: its images go beside the manifest, which haptogram_open takes. */
HAPTOGRAM_API haptogram_code haptogram_compile_rig(const haptogram_project* project, const char* rig, const char* manifest_file);

typedef struct haptogram_focus {
    double x_m, y_m, z_m;
    double amplitude; /* of the pressure, 0 to 1 of the most that the array can make there */
} haptogram_focus;

typedef struct haptogram_path {
    uint32_t size;
    const char* board;          /* a board file, or a shipped board; default: a core that suits the array */
    const char* array;          /* an array file, or a shipped array; default: the board's, or tile-10x10 */
    const haptogram_focus* foci; /* `each` for the first step, then those of the second */
    const uint32_t* periods;    /* of the carrier, for which each step lasts; default: 1 */
    size_t steps;
    uint32_t each;  /* foci at the same time; default: 1 */
    uint16_t loops; /* passes when it is played by itself; 0: for ever */
    int32_t board_computes; /* not 0: an image of foci, for boards that compute their phases; needed for live foci */
    const uint8_t* marks; /* of each step: not 0 when the trigger output of a board tells its beginning; default: none */
} haptogram_path;
HAPTOGRAM_API haptogram_code haptogram_compile_path(const haptogram_path* path, haptogram_image** image);

/* An image file, with the manifest beside it. */
HAPTOGRAM_API haptogram_code haptogram_read_image(const char* hex_file, haptogram_image** image);
HAPTOGRAM_API haptogram_code haptogram_save_image(const haptogram_image* image, const char* hex_file);
/* The Intel HEX text, and the manifest's JSON. Both return how many bytes there are, and copy at most `room` of them. */
HAPTOGRAM_API size_t haptogram_image_hex(const haptogram_image* image, char* to, size_t room);
HAPTOGRAM_API size_t haptogram_image_manifest(const haptogram_image* image, char* to, size_t room);
/* What is odd about it and does no harm, a sentence a line. */
HAPTOGRAM_API size_t haptogram_image_warnings(const haptogram_image* image, char* to, size_t room);
/* What its pressures rest on, in a sentence that begins with "nominal level" or "calibrated level". */
HAPTOGRAM_API size_t haptogram_image_level(const haptogram_image* image, char* to, size_t room);
HAPTOGRAM_API void haptogram_free_image(haptogram_image* image);

/* The amplitude of the pressure, Pa, at points of three coordinates each, when a record plays; records count from 1. Record 0 is
   the whole sequence: the root of the mean square over its time. */
HAPTOGRAM_API haptogram_code haptogram_pressure(const haptogram_image* image, uint32_t record, const double* points_m, size_t points,
                                                double* pressure_pa);
/* Drives that make several foci at the same time: for each of the array's elements a real and an imaginary part, at most 1 in
   magnitude. `elements` says how many there is room for, and then how many there are. method: "gauss-newton" and the others
   of the program; NULL: that one. */
HAPTOGRAM_API haptogram_code haptogram_solve(const char* array, const haptogram_focus* foci, size_t count, const char* method,
                                             double* drives, size_t* elements);

/* Computing, for programs with arrays of numbers of their own. Nothing of theirs is copied but what is small. Drives are complex
   source strengths, Pa m: a real and an imaginary part for each element. A focus is three coordinates. */

/* Its JSON: the "type" of its numbers as numpy calls it, such as "complex64", their "shape", and what each function says. */
HAPTOGRAM_API size_t haptogram_result_json(const haptogram_result* result, char* to, size_t room);
/* Its numbers, the last axis fastest, for as long as the result is there; NULL when it has none. */
HAPTOGRAM_API const void* haptogram_result_numbers(const haptogram_result* result);
HAPTOGRAM_API void haptogram_free_result(haptogram_result* result);

/* The shipped arrays, a name a line. */
HAPTOGRAM_API size_t haptogram_array_names(char* to, size_t room);

typedef struct haptogram_array_source {
    uint32_t size;
    const char* name;            /* an array file, or a shipped array; needed without `like` */
    const haptogram_array* like; /* one that is there */
    const char* transducer;      /* a transducer file, or a shipped one, in the place of its own */
    const double* positions_m;   /* three coordinates of each element, in the place of its own elements */
    const double* normals;       /* of each, of length 1; default: all face +z */
    size_t elements;             /* in positions_m */
    const double* seen_from;     /* its coordinates become those of a pose: an origin, and degrees about the fixed x, then y, then z axis */
} haptogram_array_source;
HAPTOGRAM_API haptogram_code haptogram_make_array(const haptogram_array_source* source, haptogram_array** array);

typedef struct haptogram_posed_array {
    const haptogram_array* array;
    const double* pose; /* as seen_from has it */
} haptogram_posed_array;
/* Several as one: the elements of the first, then those of the second. */
HAPTOGRAM_API haptogram_code haptogram_join(const haptogram_posed_array* arrays, size_t count, const char* name, haptogram_array** joined);
/* JSON: name, elements, carrier_hz, wavelength_m, transducer, and level as haptogram_image_level has it. */
HAPTOGRAM_API size_t haptogram_array_json(const haptogram_array* array, char* to, size_t room);
/* Nine doubles of each element, for as long as the array is there: its position, its normal, the real and the imaginary part of its
   response, and its weight. */
HAPTOGRAM_API const void* haptogram_array_elements(const haptogram_array* array);
/* Why a focus cannot be reached, in words; none when it can. */
HAPTOGRAM_API size_t haptogram_unreachable(const haptogram_array* array, const double* focus_m, char* to, size_t room);
HAPTOGRAM_API void haptogram_free_array(haptogram_array* array);

/* Every focus that an image has, record by record: returns how many coordinates there are, and copies at most `room` of them. */
HAPTOGRAM_API size_t haptogram_image_foci(const haptogram_image* image, double* to_m, size_t room);

/* What plays: a file, an image, pulses, or an array that focuses. */
typedef struct haptogram_source {
    uint32_t size;
    const char* file;     /* an image, a manifest, a project, a path or a shape */
    const char* manifest; /* of the file, when it is not the one beside it; of the pulses */
    const char* pulses;   /* that a simulation measured at the pins */
    const haptogram_image* image;
    const haptogram_array* array;
    const double* focus_m; /* of the array, by exact phases at full strength */
    uint32_t record;       /* this one alone; default: all in turn */
    const int32_t* cancel; /* as a project has it */
} haptogram_source;
/* Sets × elements (complex128); JSON: the "weights" of the sets. */
HAPTOGRAM_API haptogram_code haptogram_drives(const haptogram_source* source, haptogram_array** array, haptogram_result** drives);
/* What each focus of a file or an image is like while it plays alone. JSON alone: a list for each number, and about all. */
HAPTOGRAM_API haptogram_code haptogram_analyze(const haptogram_source* source, double least_force_n, haptogram_result** analysis);
/* The same of a focus that drives make, one for each element. core: a board or a configuration, whose time to load a record counts. */
HAPTOGRAM_API haptogram_code haptogram_analyze_focus(const haptogram_array* array, const double* drives, size_t elements, const double* focus_m,
                                                     const char* core, haptogram_result** analysis);

typedef struct haptogram_field {
    uint32_t size;
    const char* quantity; /* needed. In a region: "radiation" and the others of the program. At points: "complex" (pressure, Pa), "gradient"
                             (of it, Pa/m) or "mean_square" (Pa²). On axes: "complex", "mean_square", or "workspace", which needs no drives: the
                             pressure amplitude of a lone focus at each point, Pa; NaN out of reach */
    const haptogram_array* array;
    const double* drives; /* sets, one after the other */
    size_t sets;
    size_t elements;       /* drives of a set */
    const double* weights; /* of each set, its share of the time; default: all alike */
    const double* points_m; /* three coordinates each */
    size_t points;
    const double* x_m; /* straight axes; with a region from and to, where it does not spread by extent_m */
    const double* y_m;
    const double* z_m;
    size_t x_count;
    size_t y_count;
    size_t z_count;
    const char* region; /* "xy@z=130" and the others of the program, millimetres and degrees */
    const char* region_name; /* "line", "plane" or "volume", for messages; default: "region" */
    double extent_m;         /* of a region; needed there */
    double step_m;           /* between its points; needed there */
    double interpolation_error; /* on axes: how far |p| may be off, of the largest that the drives could make; default: nothing is interpolated */
    double pattern_error; /* how far a polynomial may be off a measured pattern, of the amplitude on the axis; default: none is taken */
    uint32_t threads;     /* default: one for each processor */
    const int32_t* cancel; /* as a project has it */
} haptogram_field;
/* Values at points, or z × y × x (float32 or complex64). JSON: on axes and regions method, error and pattern_error; of a region also quantity,
   x_m, y_m, z_m, and of an oblique plane its pose: an origin and three axes. */
HAPTOGRAM_API haptogram_code haptogram_compute_field(const haptogram_field* field, haptogram_result** values);
/* The bytes (uint8) of the program's file of a region's field; format: "npy" or "csv". */
HAPTOGRAM_API haptogram_code haptogram_field_file(const haptogram_result* field, const char* format, haptogram_result** bytes);

/* Several foci at the same time. */
typedef struct haptogram_foci {
    uint32_t size;
    const haptogram_array* array;
    const haptogram_focus* foci;
    size_t count;
    const char* method; /* as haptogram_solve has it */
    const char* level;  /* what amplitudes are fractions of: "reachable", the most that the array can make there, or "pressure", one for all;
                           default: "reachable" */
    int32_t vary_amplitudes; /* not 0: drives may differ in amplitude, too */
    int32_t rounds;       /* of an iterating method; default: 10 of gauss-newton, 100 of others; −1: none */
    const double* drives; /* 1 at full strength: with which solving begins, by default none, or whose quality is asked */
    size_t elements;      /* drives */
} haptogram_foci;
/* Drives, 1 at full strength, one for each element (complex128). */
HAPTOGRAM_API haptogram_code haptogram_solve_foci(const haptogram_foci* foci, haptogram_result** drives);
/* How good the foci are that drives make. JSON alone: pressure_pa of each, spread, least_over_mean, efficiency, null_share. */
HAPTOGRAM_API haptogram_code haptogram_quality(const haptogram_foci* foci, haptogram_result** quality);

/* Boards. */

typedef struct haptogram_port {
    uint32_t size;
    const char* port; /* /dev/ttyUSB0, ftdi:…, udp:ADDRESS, or reference:NAME, a simulated board of that configuration here; needed */
    uint32_t baud;    /* default: found */
    uint32_t patience_ms; /* for the first answer; default: 3000 */
    const char* rig;      /* the manifest of a rig, boards that play as one; `port` then is theirs, with blanks between; default: those in that file */
} haptogram_port;
/* A rig is opened, uploaded, played, stopped and shut off as one board is; the rest is for one board alone. Of its boards,
   channels and counters are added up. */
HAPTOGRAM_API haptogram_code haptogram_open(const haptogram_port* port, haptogram_board** board);
/* Turns the outputs off, and waits some two seconds at most for the board to confirm it. NULL is allowed, and a board that is closed already. What
   is asked of it afterwards, or is under way in another thread, fails. */
HAPTOGRAM_API void haptogram_close(haptogram_board* board);

typedef struct haptogram_identity {
    uint32_t size;
    uint32_t version_major, version_minor, channels, records, sequence_depth, clock_hz;
    uint32_t foci;               /* most at the same time that it computes by itself; 0: it computes none */
    uint32_t modulation_samples; /* 0: it has no modulation */
} haptogram_identity;
HAPTOGRAM_API haptogram_code haptogram_identify(haptogram_board* board, haptogram_identity* identity);

typedef struct haptogram_status {
    uint32_t size;
    int32_t connected, enabled, stopped; /* stopped: by its stop input */
    int32_t busy;                        /* something that was begun here plays */
    uint32_t present_index, underruns, refused_records, watchdog_trips, guard_trips, frames_damaged;
    uint64_t foci_sent; /* live, or patterns, since it began */
    double lead_s;      /* what the board has in hand meanwhile */
    uint64_t patterns_late, patterns_lost; /* that came too late for their carrier period; periods without one */
} haptogram_status;
/* What was heard last; nothing is waited for. */
HAPTOGRAM_API haptogram_code haptogram_get_status(haptogram_board* board, haptogram_status* status);

/* Writes what the board does not hold already; a rig has images of its own, so `image` is NULL. */
HAPTOGRAM_API haptogram_code haptogram_upload(haptogram_board* board, const haptogram_image* image);

typedef struct haptogram_playing {
    uint32_t size;
    int32_t loops;        /* passes of an image; default: as the image says; −1: for ever */
    uint32_t watchdog_ms; /* outputs go off when the board hears nothing of this process for so long, up to 65535; default: 500 */
    double seconds;       /* not longer than this; default: no limit */
    const char* am;       /* a waveform for all amplitudes, such as "sine:200"; default: the image's own */
    double step_s;        /* live foci: how long one stays before a newer one can follow; default: 0.2 ms, and longer on a line that is too slow */
    int32_t stale_ms;     /* live foci and patterns: silent when the newest was put longer ago, so that a program that hangs leaves none on;
                             default: as watchdog_ms; −1: they stay */
} haptogram_playing;
/* Begins, and returns; NULL is all defaults. The outputs are on until it ends. One at a time. */
HAPTOGRAM_API haptogram_code haptogram_play(haptogram_board* board, const haptogram_playing* playing);
/* The same with a focus that stays where it was put, for stale_ms, until it is put again; silent before it was put, and when it
   was refused. The end of playing forgets it. An image of foci must have been uploaded, which says where the channels are. */
HAPTOGRAM_API haptogram_code haptogram_play_live(haptogram_board* board, const haptogram_playing* playing);
/* Never waits for anything; the newest wins. May be called before haptogram_play_live. */
HAPTOGRAM_API haptogram_code haptogram_set_focus(haptogram_board* board, double x_m, double y_m, double z_m, double amplitude);
/* A pattern for each carrier period, on boards that take streams of them. A pattern is a word for each channel: in bits 7...0
   where in the period the middle of its pulse lies, in 1/256; in bits 15...8 its amplitude, 255 is full. The board's last
   records are overwritten. When no pattern waits, the last one plays on, for stale_ms; silent before the first. */
HAPTOGRAM_API haptogram_code haptogram_play_patterns(haptogram_board* board, const haptogram_playing* playing);
/* Neither waits for anything. The first appends patterns to those that wait, 4096 at most, and says how many there was room
   for; with the second the newest wins, in the place of all that wait. */
HAPTOGRAM_API haptogram_code haptogram_put_patterns(haptogram_board* board, const uint16_t* words, size_t patterns, size_t* taken);
HAPTOGRAM_API haptogram_code haptogram_set_pattern(haptogram_board* board, const uint16_t* words);
/* Waits until what was begun has ended, at most so long; says how it ended. `busy` gets whether it goes on. */
HAPTOGRAM_API haptogram_code haptogram_wait(haptogram_board* board, uint32_t milliseconds, int32_t* busy);
/* Ends what was begun in good order, and turns the outputs off. */
HAPTOGRAM_API haptogram_code haptogram_stop(haptogram_board* board);
/* Turns the outputs off ahead of everything, and waits two seconds at most for the board to confirm it. */
HAPTOGRAM_API haptogram_code haptogram_shut_off(haptogram_board* board);
/* Of all that the uploaded image plays, 0 to 1; also while it plays. */
HAPTOGRAM_API haptogram_code haptogram_set_intensity(haptogram_board* board, double factor);

/* Pins for other instruments, on boards with triggers; they stay as they are set up until the board's power is cut. */

typedef enum haptogram_event { /* what makes a pulse at the trigger output */
    HAPTOGRAM_EVENT_NONE = 0,
    HAPTOGRAM_EVENT_START = 1,     /* playing begins */
    HAPTOGRAM_EVENT_MARK = 2,      /* a step with a mark begins */
    HAPTOGRAM_EVENT_PASS = 3,      /* a pass of the sequence begins */
    HAPTOGRAM_EVENT_PERIOD = 4,    /* every so many carrier periods */
    HAPTOGRAM_EVENT_MODULATION = 5 /* the modulation begins anew */
} haptogram_event;

typedef struct haptogram_trigger {
    uint32_t size;
    uint32_t event;         /* a haptogram_event */
    uint32_t every_periods; /* of HAPTOGRAM_EVENT_PERIOD; default: 1 */
    double pulse_s;         /* for which the output is high; default: 1 ms */
    int32_t active_low;     /* the trigger input is active while it is low */
    int32_t gates;          /* no pulse reaches the transducers while the input is not active */
    double settle_s;        /* for which a change of the input must last before it counts */
} haptogram_trigger;
HAPTOGRAM_API haptogram_code haptogram_set_trigger(haptogram_board* board, const haptogram_trigger* trigger);

typedef struct haptogram_trigger_times {
    uint32_t size;
    uint32_t out_count, in_count;          /* events since power-up, modulo 65536 */
    uint64_t now_clock, out_clock, in_clock; /* of the board, since its power-up; of the last events */
} haptogram_trigger_times;
HAPTOGRAM_API haptogram_code haptogram_get_trigger_times(haptogram_board* board, haptogram_trigger_times* times);

/* The commands of a board one by one, as rtl/INTERFACE.md has them, for programs that look after their own time and signals. What
   is lost is sent again here. Nothing is said to the board but what is asked, so its watchdog watches the program. A link is for
   one thread at a time, but haptogram_link_interrupt. */

/* Opens nothing yet. Of the port's settings, `port` and `baud` have a meaning here. */
HAPTOGRAM_API haptogram_code haptogram_open_link(const haptogram_port* port, haptogram_link** link);
/* Outputs stay as they are. NULL is allowed. */
HAPTOGRAM_API void haptogram_close_link(haptogram_link* link);

/* The next three begin, and return; what went on before is interrupted. After each, haptogram_link_wait tells how it has ended, and
   then haptogram_link_replies has its replies.
   Opens the port, if it is not open, and begins a session: one reply, with the block of IDENTIFY. */
HAPTOGRAM_API haptogram_code haptogram_link_identify(haptogram_link* link);
/* Requests: of each the command, 8 bits, the length of its payload, 16 bits, little-endian, and the payload. Several are under way at
   once, and after one that is refused none is carried out. One alone can wait: `gate` is what GATE is told; 0: it does not. */
HAPTOGRAM_API haptogram_code haptogram_link_ask(haptogram_link* link, const void* requests, size_t bytes, uint64_t gate);
/* Turns the outputs off, whatever came before, without a session; if there is no answer, by a break of the line. It has failed when
   the board did not confirm it. No replies. */
HAPTOGRAM_API haptogram_code haptogram_link_shut_off(haptogram_link* link);
/* Waits until what was begun has ended, at most so long; says how it ended. `busy` gets whether it goes on. */
HAPTOGRAM_API haptogram_code haptogram_link_wait(haptogram_link* link, uint32_t milliseconds, int32_t* busy);
/* What goes on ends soon, as cancelled. */
HAPTOGRAM_API haptogram_code haptogram_link_interrupt(haptogram_link* link);
/* Replies: of each the live level, the length of its data, 16 bits each, little-endian, and the data. Returns how many bytes there
   are, and copies at most `room` of them. */
HAPTOGRAM_API size_t haptogram_link_replies(haptogram_link* link, void* to, size_t room);
/* Sends patterns for this carrier period and those after it, without an answer, as STREAM has them. */
HAPTOGRAM_API haptogram_code haptogram_link_stream(haptogram_link* link, uint64_t period, const uint16_t* words, size_t patterns);
/* From now on something new is said at least so often while something is asked, until the outputs are turned off; 0: no more. */
HAPTOGRAM_API haptogram_code haptogram_link_keep_alive(haptogram_link* link, uint32_t milliseconds);

typedef struct haptogram_link_state {
    uint32_t size;
    uint32_t found_baud; /* the rate at which the board answers, if it had to be looked for */
    uint64_t retransmissions; /* frames that were sent again */
} haptogram_link_state;
HAPTOGRAM_API haptogram_code haptogram_get_link_state(haptogram_link* link, haptogram_link_state* state);

/* The ports that a board may be behind: a line each, with a tab before what the chip says it is. Returns how many bytes there are,
   and copies at most `room` of them. */
HAPTOGRAM_API size_t haptogram_ports(char* to, size_t room);

#ifdef __cplusplus
}
#endif
#endif
