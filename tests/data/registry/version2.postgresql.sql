CREATE TABLE authority (
    one INTEGER NOT NULL CHECK (one = 1),
    public_key TEXT COLLATE "C" NOT NULL,
    head_seq BIGINT NOT NULL,
    head_hash TEXT COLLATE "C" NOT NULL,
    head_signature TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (one)
);

CREATE TABLE badges (
    id TEXT COLLATE "C" NOT NULL,
    name_nfc TEXT COLLATE "C" NOT NULL,
    layout_key TEXT COLLATE "C" NOT NULL,
    badge BYTEA NOT NULL,
    issued_at TEXT COLLATE "C" NOT NULL,
    revoked_at TEXT COLLATE "C",
    revoked_reason TEXT COLLATE "C",
    as_built BYTEA,
    as_built_at TEXT COLLATE "C",
    signature TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (id)
);

CREATE INDEX badges_by_layout ON badges (layout_key, id);

CREATE INDEX badges_by_name ON badges (name_nfc, id);

CREATE INDEX badges_by_part1 ON badges (substr(id, 5, 4));

CREATE INDEX badges_by_part2 ON badges (substr(id, 9, 4));

CREATE INDEX badges_by_part3 ON badges (substr(id, 13, 4));

CREATE TABLE log (
    seq BIGINT NOT NULL,
    time TEXT COLLATE "C" NOT NULL,
    action TEXT COLLATE "C" NOT NULL,
    subject TEXT COLLATE "C" NOT NULL,
    record_sha256 TEXT COLLATE "C" NOT NULL,
    previous TEXT COLLATE "C" NOT NULL,
    hash TEXT COLLATE "C" NOT NULL,
    signature TEXT COLLATE "C" NOT NULL,
    PRIMARY KEY (seq)
);

CREATE INDEX log_by_subject ON log (subject, seq);

CREATE TABLE schema_version (
    version INTEGER NOT NULL,
    PRIMARY KEY (version)
);
