/* Laws of impact by name. */
#include "impact/law.h"

#include <string.h>

#define LISTED(name) &name,
const struct impact_law *const all_laws[] = {ALL_LAWS(LISTED) NULL};

const struct impact_law *find_law(const char *name)
{
    for (const struct impact_law *const *law = all_laws; *law; law++)
        if (!strcmp((*law)->name, name))
            return *law;
    return NULL;
}
