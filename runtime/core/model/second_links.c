/* Forces of joints on their second links; see second_links.h. */
#include "model/second_links.h"

void turn_to_second_links(const struct ccgen_model *m, size_t blocks, size_t lanes, double *reaction)
{
    for (size_t block = 0; block < blocks; block++)
        for (int joint = 0; joint < m->joints; joint++, reaction += 3 * lanes)
            for (size_t i = 0; i < 3 * lanes && m->sides[joint] < 0; i++)
                reaction[i] = 0.0 - reaction[i]; /* no zero with a sign */
}
