/* Gives the laws e_n(v) of wetcor to C: e = sqrt(alpha + beta/v) and its kin, from numbers or from laws.csv.
 *
 * Made of capi/src/lib.rs by cbindgen: not to be edited. Every function may be called from any thread, allocates nothing
 * and throws nothing; a law may be read by many threads at once. All is in SI.
 *
 * A pointer must lead to what its type says, or be null, which is answered by WETCOR_BAD_POINTER. Texts end in a zero.
 */

#ifndef WETCOR_H
#define WETCOR_H

#include <stdint.h>

/*
 What a function answers: 0, positive where there is an answer with something to know, negative where there is none.

 Where there is none, a number to be written is NaN and a law to be made is one that every function refuses.
 */
typedef enum wetcor_status {
  /*
   it is answered
   */
  WETCOR_OK = 0,
  /*
   it is answered, at a speed outside those of the runs behind the law
   */
  WETCOR_EXTRAPOLATED = 1,
  /*
   the law is made, from a fit that is not to be quoted
   */
  WETCOR_NOT_QUOTABLE = 2,
  /*
   a pointer is null
   */
  WETCOR_BAD_POINTER = -1,
  /*
   the law was not made by this library
   */
  WETCOR_BAD_LAW = -2,
  /*
   the speed is not a finite number above zero, of 2.3e-308 at least
   */
  WETCOR_BAD_SPEED = -3,
  /*
   a number is not finite or beyond what lets no rebound gain energy, or an order or a range is none
   */
  WETCOR_BAD_NUMBER = -4,
  /*
   nothing rebounds at this speed, so that there is no slope
   */
  WETCOR_NO_REBOUND = -5,
  /*
   the header lacks a column
   */
  WETCOR_MISSING_COLUMN = -6,
  /*
   the line is not one of this header, or a cell of it cannot be read
   */
  WETCOR_BAD_LINE = -7,
  /*
   a fault of this library
   */
  WETCOR_INTERNAL = -8,
} wetcor_status;

/*
 A law e_n(v). To be copied, sent and kept as it is: 56 bytes without pointers. Its fields are not for callers.
 */
typedef struct wetcor_law {
  /*
   tells a law that was made from one that was not
   */
  uint32_t tag;
  /*
   order of the dry law taken at the impact speed; 0 where e_dry is in `constant`
   */
  uint32_t dry_order;
  /*
   k of the dry law, (m/s)^(-1/5)
   */
  double dry_k;
  /*
   alpha, or where dry_order is not 0 what the liquid's inertia takes
   */
  double constant;
  /*
   m/s
   */
  double beta;
  /*
   m^2/s^2
   */
  double kappa;
  /*
   lowest speed of the runs, m/s
   */
  double min_speed;
  /*
   highest speed of the runs, m/s
   */
  double max_speed;
} wetcor_law;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Makes e = sqrt(alpha + beta/v), beta in m/s. alpha up to 1, beta up to 0.
 */
enum wetcor_status wetcor_law_from_alpha_beta(double alpha, double beta, struct wetcor_law *law);

/*
 Makes e^2 = alpha + beta/v - kappa/v^2, beta in m/s, kappa in m^2/s^2: `reference` in column `law` of laws.csv.
 alpha up to 1, beta up to 0, kappa from 0.
 */
enum wetcor_status wetcor_law_reference(double alpha, double beta, double kappa, struct wetcor_law *law);

/*
 Makes e^2 = e_dry(v)^2 - inertial_loss + beta/v - kappa/v^2, e_dry = 1 - k v^(1/5), with + (3/5) k^2 v^(2/5) where
 dry_order is 2, not 1: `impact` in laws.csv. dry_k in (m/s)^(-1/5), from 0; inertial_loss and kappa from 0, beta up to 0.
 */
enum wetcor_status wetcor_law_impact(double dry_k,
                                     int dry_order,
                                     double inertial_loss,
                                     double beta,
                                     double kappa,
                                     struct wetcor_law *law);

/*
 Makes e = 1 - k v^(1/5), with + (3/5) k^2 v^(2/5) where dry_order is 2, not 1: `dry` in laws.csv.
 */
enum wetcor_status wetcor_law_dry(double dry_k, int dry_order, struct wetcor_law *law);

/*
 Makes the law of a line of laws.csv, whose first line is the header; a line end may stand at either's end.
 Columns are found by their names, numbers have a decimal point whatever the locale.
 WETCOR_NOT_QUOTABLE: the law is made, from a fit that is not to be quoted.
 */
enum wetcor_status wetcor_law_from_csv(const char *header, const char *line, struct wetcor_law *law);

/*
 Sets the speeds of the runs behind a law, m/s; answers outside are then WETCOR_EXTRAPOLATED. 0 <= min <= max.
 A law made from numbers has 0 and infinity. Where it fails the law is left as it was.
 */
enum wetcor_status wetcor_law_set_range(struct wetcor_law *law, double min_speed, double max_speed);

/*
 Writes e_n at an impact speed v, m/s; 0 where nothing rebounds.
 */
enum wetcor_status wetcor_restitution(const struct wetcor_law *law, double v, double *e);

/*
 Writes d ln e / d ln v at an impact speed v, m/s; WETCOR_NO_REBOUND where nothing rebounds.
 */
enum wetcor_status wetcor_log_slope(const struct wetcor_law *law, double v, double *slope);

/*
 Writes the speed below which nothing rebounds, m/s: 0 where everything does, infinity where nothing does.
 */
enum wetcor_status wetcor_threshold_speed(const struct wetcor_law *law, double *v);

/*
 Writes the lowest and the highest speed of the runs behind a law, m/s: 0 and infinity where they are not known.
 */
enum wetcor_status wetcor_range(const struct wetcor_law *law, double *min_speed, double *max_speed);

/*
 What a status means, in English, for as long as the program runs; also of a number that is none.
 */
const char *wetcor_status_text(int status);

/*
 The version of the library, such as 0.2.0, for as long as the program runs.
 */
const char *wetcor_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* WETCOR_H */
