/* pmcip for C99 and C++17. Made by cbindgen from src/capi: do not edit. */

#ifndef PMCIP_H
#define PMCIP_H

#include <stdint.h>
#include <stddef.h>

/*
 What a call came to. `pmcip_message` says it in words.
 */
typedef enum pmcip_status {
  /*
   It was done.
   */
  PMCIP_STATUS_OK = 0,
  /*
   There are no more jobs.
   */
  PMCIP_STATUS_DONE = 1,
  /*
   A pointer that must not be NULL is, or is not aligned.
   */
  PMCIP_STATUS_POINTER = 2,
  /*
   Memory is shorter than asked for.
   */
  PMCIP_STATUS_MEMORY = 3,
  /*
   A setting is out of range.
   */
  PMCIP_STATUS_SETTINGS = 4,
  /*
   An iteration without samples, or with more than 2^32 - 1.
   */
  PMCIP_STATUS_SAMPLES = 5,
  /*
   Calls in the wrong order: begin, then the samples, then end; read between iterations.
   */
  PMCIP_STATUS_ORDER = 6,
  /*
   Not all samples of the iteration have been delivered.
   */
  PMCIP_STATUS_UNFINISHED = 7,
  /*
   The film accumulates for another estimator.
   */
  PMCIP_STATUS_ESTIMATOR = 8,
  /*
   Labels are all 0.
   */
  PMCIP_STATUS_LABELS = 9,
  /*
   Arrays have no room for the samples of a single pixel.
   */
  PMCIP_STATUS_ROOM = 10,
  /*
   A piece that was delivered already, is of another iteration, or comes with another number of radiances.
   */
  PMCIP_STATUS_PIECE = 11,
  /*
   Bytes that are not a saved film of this version.
   */
  PMCIP_STATUS_SAVED = 12,
  /*
   A fault of the library: please report it. The film must not be used any more.
   */
  PMCIP_STATUS_FAULT = 13,
} pmcip_status;

/*
 Which estimator makes the picture.
 */
typedef enum pmcip_estimator {
  /*
   The mean of all samples: biased.
   */
  PMCIP_ESTIMATOR_POOLED = 0,
  /*
   The average of the iterations' pictures.
   */
  PMCIP_ESTIMATOR_SUBFRAME = 1,
  /*
   The mean of each pixel's first samples: unbiased, and noisy.
   */
  PMCIP_ESTIMATOR_DIFFERENCE = 2,
  /*
   Pooled, with the energy it lost given back to the neighbourhood. The default.
   */
  PMCIP_ESTIMATOR_BALANCED = 3,
} pmcip_estimator;

/*
 A film in memory that the caller lends.
 */
typedef struct pmcip_film pmcip_film;

/*
 A job, in memory the caller lends.
 */
typedef struct pmcip_job pmcip_job;

/*
 The jobs of an iteration, in memory the caller lends.
 */
typedef struct pmcip_jobs pmcip_jobs;

/*
 Everything a film is asked for. Fill it by `pmcip_settings_new` and change what you like.
 */
typedef struct pmcip_settings {
  /*
   Columns and rows, 1 to 16384.
   */
  uint32_t width;
  /*
   Rows.
   */
  uint32_t height;
  /*
   Seed of all randomness.
   */
  uint32_t seed;
  /*
   Number of the frame: another frame has other noise.
   */
  uint32_t frame;
  /*
   Luminance in cd/m^2 of radiance 1; positive.
   */
  float cd_per_unit;
  /*
   The same number of samples everywhere, if not 0.
   */
  uint32_t uniform;
  /*
   What is accumulated: a `pmcip_estimator`.
   */
  uint32_t estimator;
  /*
   Sequences begin anew in every iteration, if not 0.
   */
  uint32_t fresh;
  /*
   Exponent of the weights, 0 to 4.
   */
  float gamma;
  /*
   Part of the samples that is given out uniformly, 0 to 1.
   */
  float epsilon;
  /*
   Part of an iteration that is promised to every pixel until it has its fair samples, 0 to 1.
   */
  float defensive;
  /*
   First samples of each pixel that the energy is taken from; 0 to let `pmcip_settings_new` choose.
   */
  uint32_t fair;
  /*
   Radius in pixels over which energy is given back, at most 4096.
   */
  uint32_t balance_radius;
} pmcip_settings;

/*
 What is believed of a pixel before a frame has seen it.
 */
typedef struct pmcip_belief {
  /*
   Variance of a sample's luminance.
   */
  float variance;
  /*
   Mean luminance.
   */
  float light;
  /*
   Of how many samples more than one the variance could be; 0: nothing is known.
   */
  float freedom;
} pmcip_belief;

/*
 A part of the film whose samples were planned together.
 */
typedef struct pmcip_piece {
  /*
   The first pixel, in storage order.
   */
  size_t first;
  /*
   One after the last: where the next piece begins; the number of the film's pixels after the last piece.
   */
  size_t end;
  /*
   Samples planned.
   */
  size_t samples;
} pmcip_piece;

/*
 Samples of all iterations.
 */
typedef struct pmcip_tally {
  /*
   Samples in the film.
   */
  uint64_t samples;
  /*
   Samples left out because a component was not finite or beyond 1e15.
   */
  uint64_t rejected;
} pmcip_tally;

/*
 What is seen through a pixel, averaged over it; all 0 where nothing is.
 */
typedef struct pmcip_feature {
  /*
   Part of the light that the surface reflects, 1 where it shines itself.
   */
  float albedo[3];
  /*
   Shading normal.
   */
  float normal[3];
  /*
   Length of the way from the eye, in any unit.
   */
  float depth;
} pmcip_feature;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 What a status means, in words: a string that is always there.
 */
const char *pmcip_message(uint32_t status);

/*
 Writes the default settings of a film of this size, for a frame of `spp` samples a pixel, `pilot` of them in the first
 iteration; 0 for both if nothing is known of what follows.

 # Safety
 `settings` is NULL or points to settings.
 */
enum pmcip_status pmcip_settings_new(uint32_t width,
                                     uint32_t height,
                                     uint32_t pilot,
                                     uint32_t spp,
                                     struct pmcip_settings *settings);

/*
 Bytes of memory that a film takes, with labels if `labelled` is not 0; SIZE_MAX if there is no such film.
 */
size_t pmcip_film_size(uint32_t width, uint32_t height, uint32_t labelled);

/*
 Makes an empty film in `memory` of `size` bytes, whatever that holds, and writes where it is to `made`.

 `labels` is NULL, or has an entry for every pixel, row by row from the top: to which island a pixel belongs, 0 to none.
 They are copied.

 # Safety
 Pointers are NULL or point to as much as is said; `memory` is not used otherwise while the film is.
 */
enum pmcip_status pmcip_film_create(void *memory,
                                    size_t size,
                                    const struct pmcip_settings *settings,
                                    const uint16_t *labels,
                                    struct pmcip_film **made);

/*
 Number of pixels that get samples: all, or those of a label other than 0. 0 if `film` is none.

 # Safety
 `film` is NULL or a film.
 */
uint64_t pmcip_film_pixels(struct pmcip_film *film);

/*
 Begins an iteration of `samples` samples over all pixels: plans how many each gets.

 # Safety
 `film` is NULL or a film.
 */
enum pmcip_status pmcip_film_begin(struct pmcip_film *film, uint64_t samples);

/*
 Begins an iteration with what earlier frames tell: one belief a pixel, row by row, of which none stems from this film.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_begin_beliefs(struct pmcip_film *film,
                                           uint64_t samples,
                                           const struct pmcip_belief *beliefs);

/*
 Begins an iteration with a kernel of the caller's: how many samples each pixel gets in proportion, row by row; none
 where it is 0.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_begin_alpha(struct pmcip_film *film,
                                         uint64_t samples,
                                         const float *alpha);

/*
 Writes samples of the running iteration, from pixel `first` on (0, or the end of a piece), as many as fit into arrays of
 `room` entries, and says which they are. Nothing changes by it.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_plan(struct pmcip_film *film,
                                  size_t first,
                                  size_t room,
                                  float *x,
                                  float *y,
                                  uint32_t *index,
                                  uint32_t *key,
                                  struct pmcip_piece *piece);

/*
 Takes the radiances of a piece, `samples` times linear RGB in the order of its samples. Pieces may come in any order.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_deliver(struct pmcip_film *film,
                                     const struct pmcip_piece *piece,
                                     const float *rgb,
                                     size_t samples);

/*
 Ends the iteration, when all samples have been delivered. `tally`, if not NULL, gets what there is since the first one.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_end(struct pmcip_film *film,
                                 struct pmcip_tally *tally);

/*
 Bytes of memory that `pmcip_jobs` take.
 */
size_t pmcip_jobs_size(void);

/*
 Bytes of memory that a `pmcip_job` takes.
 */
size_t pmcip_job_size(void);

/*
 Divides what is left of the running iteration into jobs, for threads. `memory` has `size` bytes.

 # Safety
 Pointers are NULL or point to as much as is said. Until the last job has been delivered no other call takes the film.
 */
enum pmcip_status pmcip_jobs_begin(struct pmcip_film *film,
                                   void *memory,
                                   size_t size,
                                   struct pmcip_jobs **jobs);

/*
 Writes the next job into `memory` of `size` bytes; `PMCIP_STATUS_DONE` if there is none. By one thread at a time.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_jobs_next(struct pmcip_jobs *jobs,
                                  void *memory,
                                  size_t size,
                                  struct pmcip_job **job);

/*
 Writes the next samples of a job, at most `room` of them, and how many to `samples`: 0 at its end.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_job_plan(struct pmcip_job *job,
                                 size_t room,
                                 float *x,
                                 float *y,
                                 uint32_t *index,
                                 uint32_t *key,
                                 size_t *samples);

/*
 Takes the radiances of the next `samples` samples that were planned, in the same order.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_job_deliver(struct pmcip_job *job, const float *rgb, size_t samples);

/*
 Writes the points of set `set` (1 or higher) of `samples` samples, coordinates in [0, 1).

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_points(uint32_t set,
                               size_t samples,
                               const uint32_t *index,
                               const uint32_t *key,
                               float *u,
                               float *v);

/*
 Floats of scratch that the pictures of a film of this size take.
 */
size_t pmcip_scratch_size(uint32_t width, uint32_t height);

/*
 Writes the picture: linear RGB, row by row from the top. `scratch` has `floats` entries.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_resolve(struct pmcip_film *film,
                                     uint32_t estimator,
                                     float *scratch,
                                     size_t floats,
                                     float *rgb);

/*
 Writes any picture of the same size, `guide`, with the energy of the film: linear RGB, row by row.

 # Safety
 Pointers are NULL or point to as much as is said; `guide` is not `rgb`.
 */
enum pmcip_status pmcip_film_resolve_guided(struct pmcip_film *film,
                                            const float *guide,
                                            float *scratch,
                                            size_t floats,
                                            float *rgb);

/*
 Floats of scratch that `pmcip_film_filter` takes.
 */
size_t pmcip_filter_size(uint32_t width, uint32_t height, uint32_t labelled);

/*
 Writes the filtered picture, a guide for `pmcip_film_resolve_guided`. `features` is NULL or has one entry a pixel, row by
 row; `scratch` has `floats` entries. About 4 microseconds a pixel on this thread.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_filter(struct pmcip_film *film,
                                    const struct pmcip_feature *features,
                                    float *scratch,
                                    size_t floats,
                                    float *guide);

/*
 Writes the variance of every pixel's mean luminance, row by row.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_variance(struct pmcip_film *film, float *variance);

/*
 Writes how many samples every pixel has, row by row.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_count(struct pmcip_film *film, uint32_t *count);

/*
 Writes the kernel of the current or last iteration, row by row; it sums to one.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_alpha(struct pmcip_film *film, float *alpha);

/*
 Writes what the film believes of every pixel, row by row, for `pmcip_film_begin_beliefs` of the next frame.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_beliefs(struct pmcip_film *film, struct pmcip_belief *beliefs);

/*
 Bytes of the saved film; 0 if `film` is none.

 # Safety
 `film` is NULL or a film.
 */
size_t pmcip_film_saved_size(struct pmcip_film *film);

/*
 Writes the film as bytes, exactly as many as `pmcip_film_saved_size` says, the same on every machine.

 # Safety
 Pointers are NULL or point to as much as is said.
 */
enum pmcip_status pmcip_film_save(struct pmcip_film *film, uint8_t *bytes, size_t size);

/*
 Makes the film that was saved as `bytes` in `memory` of `size` bytes. With `memory` NULL, says in `needed` how many
 bytes that takes.

 # Safety
 Pointers are NULL or point to as much as is said; `memory` is not used otherwise while the film is.
 */
enum pmcip_status pmcip_film_load(const uint8_t *bytes,
                                  size_t length,
                                  void *memory,
                                  size_t size,
                                  size_t *needed,
                                  struct pmcip_film **made);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* PMCIP_H */
